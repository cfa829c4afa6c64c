"""A linear matrix inequality as data, and the functions that read it."""
