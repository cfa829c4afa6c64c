"""Candidates of claims about a turbine's loop.

effort_sharing         the loop with the effort-sharing law: cells, one P for all; where that fails
largest_wind_error     the wind class that is tried, and the largest wind error of every cell
cell_loop              one wind cell's coefficients, as the checker encloses them
loop_claims            the claim about the loop, and the claims that depend on it
wind_rate_claim        how fast a wind that the law knows may move
published              the loop with a published law, over a grid of overlaps
published_search       its cells: a centre, a box and a P for each
running_candidate      the loop with its observer and filters: one cell, by a semidefinite program
running_loop_claim     its claim: cells over all winds
"""
