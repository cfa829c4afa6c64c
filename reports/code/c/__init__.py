"""The law as C99 without dependencies."""
