"""The effort-sharing law (``coherent`` on the command line)."""
