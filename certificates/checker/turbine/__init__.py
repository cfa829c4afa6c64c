"""The turbine's loops.

effort_sharing/    the loop with one law for all winds, and claims that depend on its claim
published/         the loop with a published law, at constant winds
running_loop/      the loop with one law, its observer and its filters, at constant winds
rotor              the turbine's numbers, and the slopes of the rotor's torque
turbine_claim      what claims about a turbine's loop have in common
members            the members of turbine and observer; others are refused
"""
