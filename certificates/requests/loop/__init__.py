"""The loop that requests are about, and the search tools.

loop                 floats to find candidates, the checker's reading to prove
disturbance_channel  from which disturbance to which output
decimals             short decimals for what is stated; the checker's matrices as floats
float_filter         a fast float test that avoids useless exact arithmetic
weight_points        weights to try: rules alone, blends of shares
piece_search         pieces of the weights on which a claim can be shown
single_matrix        quadratic functions of a single matrix
quadratic_motion     the change of V = x'Px along blends
valid_level          the largest valid level of an ellipsoid
"""
