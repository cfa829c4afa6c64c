"""The candidate of a claim about the loop around the trim at the schedule wind, in moving wind.

posed_cells          cells and boxes in the units of a solver
schedule_program     the semidefinite programs
schedule_rate_claim  the search over a range of schedule winds
schedule_ranges      the ranges of schedule winds, and the rates, that a command searches
"""
