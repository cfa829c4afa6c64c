"""Gains with a structure: zeros, shared gains, outputs in the place of states.

structure, plant   what the law may look at, and what the objective is about
sums, slack        the convex steps;  steps, climb, units  the search over several starts
design, answer     what is called, and what it hands back
"""
