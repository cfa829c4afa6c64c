"""Gains for a decay rate.

Parallel distributed compensation by one relaxation, or by one relaxation after another.
"""
