"""The turbine's loop about the trim at the schedule wind, in moving wind (``schedule-rate``).

schedule_inputs  what a claim states of each cell
schedule_cell    the law's numbers and the torque's slopes over the box of one cell
schedule_loop    the loop's rates, and the rows of its box
schedule_limits  proof that the loop's other limits are not reached on the set
schedule_claim   the verdict on one claim

Derived in docs/schedule-rate.md.
"""
