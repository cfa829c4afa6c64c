"""From a condition to an answer that passes an independent check.

Feasible or not, the best objective, and which items stand in the way.
"""
