"""The closed loop that claims are about, with exact numbers.

Its vertices and gains, pieces of its weights, and where the model is valid.
"""
