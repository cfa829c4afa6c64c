"""The effort-sharing law (``coherent`` on the command line).

law           one effort, divided between generator torque and blade pitch by a ramp
schedule      what it looks up over wind
feedforward   what it feeds forward of its schedule wind's own rate
"""
