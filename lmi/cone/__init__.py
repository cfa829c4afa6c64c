"""A condition as cone-program data.

Assembled without a loop over items, scaled, and bounded from its multipliers.
"""
