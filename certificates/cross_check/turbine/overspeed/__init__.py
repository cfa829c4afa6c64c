"""A rotor speed that turbulence seldom reaches, written from docs/turbulence-speed.md.

seldom_reached  the conditions of the claim
asked            what the law asks for at least while the rotor is fast
driven           the greatest torque of the rotor
"""
