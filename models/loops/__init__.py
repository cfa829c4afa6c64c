"""Closed loops as families of matrices: plant and law enclosed together, cell by cell.

Secant embedding: over a convex region the difference of a C^1 map at two points is a matrix times
their difference, with entries in the ranges of the partial derivatives.  The ranges are rigorous
enclosures, so what holds for every matrix of the family holds for the nonlinear loop.
"""
