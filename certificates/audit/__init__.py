"""Information about a check itself: the files and lines of the checker that a verdict used."""
