"""The closed loop with a published law, enclosed cell by cell.

Intervals with slopes of its right-hand side.
"""
