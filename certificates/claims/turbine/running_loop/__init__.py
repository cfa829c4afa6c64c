"""The candidate of the claim about the effort-sharing loop as it runs, with its observer.

running_loop_claim  the claim: cells over all winds
candidate           the box and the quadratic function of one cell, by a semidefinite program

The equations and the ranges of their factors are the checker's
(``checker.turbine.running_loop``): nothing is enclosed here.
"""
