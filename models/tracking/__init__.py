"""Outputs that follow references: integral states of the law, and where the loop rests.

following       a plant with an integral state for each reference
loop_rests      the same for the loop, as a linear function of the signals
held_rests      where the plant rests for each reference, numerically, and what its inputs can hold
"""
