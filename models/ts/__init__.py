"""Takagi-Sugeno models as values.

Vertex matrices, premises with proved ranges, and the derivation that a model came from.
"""
