"""Why there was no answer, and what would help, measured."""
