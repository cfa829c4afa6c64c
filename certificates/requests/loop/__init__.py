"""The loop that requests are about, and the search tools.

loop                 floats to find candidates, the checker's reading to prove
disturbance_channel  from which disturbance to which output
decimals             short decimals for what is stated; the checker's matrices as floats
weight_pieces        weights to try, and pieces of the weights on which a claim can be shown
single_matrix        quadratic functions of a single matrix; a fast test of them in floats
set_level            levels of an ellipsoid: in the model's box, and under a disturbance
"""
