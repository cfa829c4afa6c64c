"""The options of the command line, and their translation into settings."""
