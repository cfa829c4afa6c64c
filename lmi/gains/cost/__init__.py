"""Gains with the least guaranteed quadratic cost.

The linear-quadratic regulator of a Takagi-Sugeno model.
"""
