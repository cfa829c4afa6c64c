"""A condition as cone-program data."""
