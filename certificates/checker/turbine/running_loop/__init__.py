"""The claim about a turbine's loop as it runs, with its observer and filters (``running-loop``).

inputs         observer, filters and box as the claim states them
cell           one cell of winds: tables, torque surface, equilibrium, and the loop's factors
equations      the loop as signals with uncertain factors, and its decay inequality over integers
limits         proof that limits missing in the equations are not reached
running_claim  the claim
"""
