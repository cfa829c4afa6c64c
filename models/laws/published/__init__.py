"""The published multi-region law (``schulte`` on the command line, ``paper`` in files)."""
