"""The second checker's claim about the turbine's loop with its observer (``running-loop``).

running_loop   the conditions of a claim, cell by cell
machine        observer, filters and box as the claim states them
cell           ranges of the loop's factors over the box of one cell
rates          the loop as a matrix over states and uncertain products

Written from docs/running-loop.md.
"""
