"""The closed loop with the effort-sharing law as an interval family of matrices, one for each wind
cell, with its corners.
"""
