"""A linear matrix inequality as data.

Unknowns, terms, eigenvalue regions, uncertainty; and its readers in floats, rationals, cvxpy and
LaTeX.
"""
