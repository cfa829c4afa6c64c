"""Matrix polynomials in memberships, by their coefficients.

simplex_polynomials     coefficients on a product of simplexes, known or sought; P(h) of them
"""
