"""Matrix expressions that are written with operators and are affine in the unknowns.

piece            one summand: left X right, or a known matrix
expression       sums of pieces in blocks, with @, *, +, -, .T, >>, <<, >=, <=, ==
matrices         He, block, trace, and known matrices with a name
"""
