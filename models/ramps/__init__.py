"""Ramps that hand one quantity over to another.

The effort ramp in floats and in exact numbers, and the membership pair w_1 + w_2 = 1.
"""
