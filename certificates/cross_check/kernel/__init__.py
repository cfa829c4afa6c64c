"""Code that all parts of the second checker use.

reading       a certificate file as plain data, with exact rationals
exact         exact matrices, and definiteness by their characteristic polynomials
obligation    the conditions of a claim: a matrix that must be definite, a fact that must hold
"""
