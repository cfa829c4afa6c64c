"""Gains with a structure: zeros, shared gains, outputs in the place of states.

structure, disturbed_plant    what the law may look at, and what the objective is about
sums, slack_matrix      the convex steps
joint_steps, local_search, coordinates    the search over several starts
design, answer          what is called, and what it hands back
"""
