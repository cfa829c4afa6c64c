"""What every HTML report has: the page, tables and figures as macros, shared sections, styles."""
