"""Exact reasons for a no: multipliers and functions, checked by integers alone.

adjoint        a condition as one integer matrix
alternative    multipliers that rule a condition out;  objective_limit  ... that bound an objective
indefinite     a function that decays but is not positive;  definiteness  the test of a matrix
"""
