"""Gains together with a Lyapunov function that depends on the memberships.

compensation, design    what is called, and what it hands back
task, sums, limits      the LMIs;  search  from them to a law, or to a reasoned no
"""
