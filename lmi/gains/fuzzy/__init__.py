"""Gains together with a Lyapunov function that depends on the memberships.

pdc              the function that is called
request, sums    the LMIs, and what keeps their unknowns finite
design           from them to a law, or to a reasoned no
"""
