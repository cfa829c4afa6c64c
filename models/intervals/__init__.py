"""Interval arithmetic and best-first search over boxes.

What every proved range is computed with.
"""
