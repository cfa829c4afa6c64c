"""The second checker's claims about a turbine with the effort-sharing law.

loop_claim                  the matrix inequalities, cell by cell
numbers, surface            turbine, law and box; the coefficient surface
ranges, moving_schedule     the stated ranges enclose the turbine; the schedule wind moves
effort_ramp                 the ramp by which torque and pitch share an effort
wind_rate, actuator_rates   what rests on the claim
equilibrium                 at how many states the loop rests, from its torque_balance
"""
