"""The second checker's claims about a turbine with the effort-sharing law.

loop_claim                  the matrix inequalities, cell by cell
numbers, surface            turbine, law and box; the coefficient surface
ranges                      the stated ranges enclose the turbine, also while the schedule moves
rates                       claims about rates, which depend on the loop claim
running_loop, running_cell  the loop with its observer and filters, at constant winds
members                     the members that a claim may have
"""
