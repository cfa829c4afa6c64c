"""The second checker's claim about the turbine's linear loop in turbulence.

turbine_crossing   the conditions of a claim (``turbine-crossing``)
linear_rates       the loop's matrix at one wind, and the ranges of its parameters

Written from docs/turbine-crossing.md.
"""
