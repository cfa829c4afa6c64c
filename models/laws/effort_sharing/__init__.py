"""The effort-sharing law (on the command line.

Coherent): one effort, divided between generator torque and blade pitch by a ramp.
"""
