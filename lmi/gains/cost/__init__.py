"""Gains with the least guaranteed quadratic cost.

regulator         the linear-quadratic regulator of a Takagi-Sugeno model
condition         its LMIs
guaranteed_cost   one gain for all vertices, in given engineering ranges
"""
