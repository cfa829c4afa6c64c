"""Interval arithmetic and best-first search over boxes: what proved ranges are computed with.

interval      closed intervals of rational numbers, exact
dual, jet     ranges with slopes, in floats; second-order Taylor arithmetic in one variable
box_search    best-first bisection of boxes, however they are enclosed
"""
