"""A plant as the user writes it: equations, and variables with units and ranges, as values."""
