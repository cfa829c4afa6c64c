"""Polynomial Lyapunov functions by sums of squares, posed as LMIs.

polynomial        polynomials of the state with exact coefficients, monomials, Gram matrices
decrease          where V' may be 0: coordinates, weights, LaSalle's theorem
attraction_level  the largest level of a polynomial function inside the region of attraction
"""
