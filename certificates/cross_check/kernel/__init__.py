"""Code that all parts of the second checker use.

reading       a certificate file as plain data, with exact rationals
exact         exact matrices, definite by their characteristic polynomials
obligation    a matrix that must be definite, a fact that must hold
"""
