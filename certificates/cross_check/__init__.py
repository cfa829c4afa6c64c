"""A second decision of every obligation, in FLINT's numbers, and its comparison with the first.

flint_decider  decides matrices, numbers and ranges of expressions with python-flint
ball_ranges    ranges of expressions in FLINT's ball arithmetic
comparison     the verdicts of both, claim by claim
"""
