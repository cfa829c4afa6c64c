"""The claim about a turbine's loop as it runs, with its observer and filters (``running-loop``).

inputs          observer, filters and box as the claim states them
cell            one cell of winds: the law's tables, the surface and the rest
factors         the ranges of the loop's factors over a box
equations       the loop as signals with uncertain factors
signals         such signals, and the matrix of the decay inequality
limits          limits that the equations leave out are not reached
running_claim   the verdict on one claim
"""
