"""Matrix expressions that are written with operators and are affine in the unknowns.

constant_data    reading of a known matrix, or of one for each vertex; its symbol
piece            one summand: left X right, or a known matrix
expression       sums of pieces in blocks, with @, *, +, -, .T, >>, <<, >=, <=, ==
matrices         He, block, trace, and known matrices with a name
"""
