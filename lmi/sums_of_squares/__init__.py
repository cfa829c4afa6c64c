"""Polynomial Lyapunov functions by sums of squares, posed as LMIs.

polynomial            polynomials of the state with exact coefficients, monomials, Gram matrices
homogeneous_lyapunov  common forms of degree 2, 4, 6, ... of a polytope of matrices
decrease              where V' may be 0: coordinates, weights, LaSalle's theorem
attraction_level      the largest level of a polynomial function inside the region of attraction
"""
