"""The second checker's claims about a turbine with the effort-sharing law.

loop_claim                  the matrix inequalities, cell by cell
numbers, surface            turbine, law and box; the coefficient surface
ranges, moving_schedule     the stated ranges enclose the turbine; the effects of a moving schedule
effort_ramp                 the ramp that shares an effort between torque and pitch
wind_rate, actuator_rates   claims that depend on the loop claim
running                     the loop with its observer and filters, at constant winds
"""
