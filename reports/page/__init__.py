"""The elements of every HTML page."""
