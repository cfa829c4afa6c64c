"""A condition as cone-program data.

program      what a solver is given, and what it gives back
assemble     from a condition to cone data, without a loop over items
balance      coordinates in which the numbers are of order one
duality      bounds on the optimum that multipliers give
"""
