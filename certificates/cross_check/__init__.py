"""A second decision of every obligation, in FLINT's numbers, and its comparison with the first."""
