"""The only calls of a solver: cone data in, numbers out."""
