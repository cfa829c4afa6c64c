"""Code that every check uses: strict reading, exact matrices, obligations and verdicts."""
