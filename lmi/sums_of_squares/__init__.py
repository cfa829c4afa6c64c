"""Polynomial Lyapunov functions by sums of squares, posed as LMIs.

monomials             exponents, and the motion of monomials along x' = A x
polynomial            polynomials of the state with exact coefficients
gram                  Gram matrices: the L with m' L m = 0, and identities as equalities
homogeneous_lyapunov  common forms of degree 2, 4, 6, ... of a polytope of matrices
attraction_level      the largest level of a polynomial function inside the region of attraction
"""
