"""Gains with a structure: zeros, shared gains, outputs in the place of states.

structure                  which measurements each input may use
sums, slack_matrix         the conditions of the convex steps
joint_steps                one step: P for given gains, then P and gains together
local_search               many steps from several starts; starts by descent on the norm itself
design                     ``structured_pdc``, its plant and its result
"""
