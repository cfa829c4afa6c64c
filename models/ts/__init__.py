"""Takagi-Sugeno models as values."""
