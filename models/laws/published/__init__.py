"""The published multi-region laws (``paper`` and ``paper-two-integrators`` on the command line)."""
