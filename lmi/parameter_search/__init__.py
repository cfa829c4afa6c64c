"""The best value of a parameter in a condition.

Generalised eigenvalues, sweeps, and the decay rate with the least bound.
"""
