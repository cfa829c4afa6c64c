"""Matrix expressions that are written with operators and are affine in the unknowns.

piece            one summand: left X right, or a known matrix with its symbol
expression       sums of pieces in blocks, with @, *, +, -, .T, >>, <<, >=, <=, ==; He, block, trace
"""
