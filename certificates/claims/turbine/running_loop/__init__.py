"""The candidate of the claim about the effort-sharing loop as it runs, with its observer.

running_loop_claim  the claim: cells over all winds
candidate           the box and the quadratic function of one cell
cell_program        the semidefinite program for them
running_rate_claim  the claim in moving wind: ranges of winds, and the rate of the wind in each cell
moving_cell         boxes, functions and multipliers for it
moving_program      the semidefinite programs for these
bridges             cells in the gaps between cells that were found
cell_chain          functions for several cells beside one another; joint_program is the program
entered_cells       the room in its box that a cell needs to be entered from others
sparse_program      a cone program with few entries

The equations and the ranges of their factors are the checker's
(``checker.turbine.running_loop``): nothing is enclosed here.
"""
