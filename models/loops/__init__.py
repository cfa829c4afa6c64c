"""Closed loops as families of matrices: plant and law enclosed together, cell by cell.

secant/            any plant under a given feedback law
effort_sharing/    the turbine with the effort-sharing law, one family a wind cell
published/         the turbine with a published law

Secant embedding: over a convex region the difference of a C^1 map at two points is a matrix times
their difference, with entries in the ranges of the partial derivatives.  The ranges are rigorous
enclosures, so what holds for every matrix of the family holds for the nonlinear loop.
"""
