"""Code that all parts of the second checker use.

reading       a certificate file as plain data, with exact rationals
exact         exact matrices, a test of definiteness, and the conditions of a claim
"""
