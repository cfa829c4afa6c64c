"""A rotor speed that turbulence seldom exceeds, written from docs/turbulence-speed.md.

seldom_exceeded  the conditions of the claim
asked            what the law asks for at least while the rotor is fast
driven           the greatest torque of the rotor
"""
