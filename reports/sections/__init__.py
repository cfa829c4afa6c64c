"""The HTML reports: one folder for each, and what both share."""
