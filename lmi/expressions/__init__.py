"""Matrix expressions that are written with operators and are affine in the unknowns."""
