"""The second checker's claim about the loop around the trim at the schedule wind.

scheduled_loop   the conditions of a claim (``schedule-rate``)
scheduled_cell   ranges of the loop's factors over the box of one cell, and limits
scheduled_rates  the loop as a matrix over states, inputs and uncertain products

Written from docs/schedule-rate.md.
"""
