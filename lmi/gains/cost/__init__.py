"""Gains with the least guaranteed quadratic cost."""
