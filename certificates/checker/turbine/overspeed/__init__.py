"""A rotor speed that is reached in turbulence with a small probability (``turbulence-speed``).

speed_inputs  what the claim states
sent          the least torque that the law asks for above a measured speed
rotor_torque  the greatest torque of the rotor over ranges of speed and wind
speed_claim   the verdict on one claim

Derived in docs/turbulence-speed.md.
"""
