"""Gains together with a Lyapunov function that depends on the memberships.

pdc, design      the function that is called, and its result
request, sums, limits    the LMIs, and what keeps their unknowns finite
search           from them to a law, or to a reasoned no
"""
