"""Matrix polynomials in memberships, by their coefficients.

simplex_polynomials     known coefficients, on a product of simplexes
unknown_polynomial      coefficients that are sought, and what they add to an LMI
polynomial_lyapunov     a Lyapunov matrix P(h) that changes with the memberships
"""
