"""The turbine's loop linearised at one wind, in turbulence (``turbine-crossing``).

trim             the numbers of turbine and law at one wind, exactly
jacobian         the loop's matrix for given values of the parameters
pieces           the ranges of the parameters, and their tree of halves
crossing_claim   the verdict on one claim
"""
