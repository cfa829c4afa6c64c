"""Given gains: the decay rate of the loop u = -sum_j h_j K_j x by each relaxation.

condition        the double sum of a loop with given gains, and one P for all blends
largest_decay    the decay rate that a relaxation shows; all relaxations for the same gains
"""
