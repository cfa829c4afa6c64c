"""The loop that requests are about, and what they search it with.

loop                 floats to find candidates, the checker's reading to prove
disturbance_channel  from which disturbance to which output
decimals             short decimals for what is stated
exact_floats         the checker's exact matrices as floats
float_filter         a quick look that spares the exact arithmetic
weight_points        weights to try: rules alone, blends of shares
piece_search         pieces of the weights on which a claim can be shown
single_matrix        quadratic functions of a single matrix
quadratic_motion     what V = x'Px does along blends
valid_level          how large an ellipsoid may be
"""
