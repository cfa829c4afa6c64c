"""The closed loop that claims are about, with exact numbers.

polytopic_loop     vertices and gains as exact matrices, and the blends to which claims apply
blends, halvings   the blends of a claim; pieces of the weights
averages           claims that are impossible for weights that are averages
box_of_validity    an ellipsoid lies in the box where the model is valid
"""
