"""Ramps that hand one quantity over to another.

effort_ramp           how torque and pitch share one effort, in floats
exact_effort_ramp     the ramp in exact numbers, with the slopes of its secants
membership_ramp       the membership pair w_1 + w_2 = 1
"""
