"""The HTML reports: one folder for each, one file for each section of the page."""
