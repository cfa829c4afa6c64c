"""The candidate of a claim that turbulence seldom drives the rotor to a speed.

speed_candidate  the highest wind for a probability, and the least speed that can be shown for it
"""
