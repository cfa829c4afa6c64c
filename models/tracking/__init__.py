"""Outputs that follow references: integral states of the law, and equilibria of the loop.

following       a plant with an integral state for each reference
held_rests      the plant's equilibrium for each reference, numerically, if the inputs can hold it
loop_equilibria the equilibria of the loop as a linear function of the signals
"""
