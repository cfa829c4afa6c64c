"""Gains with a structure: zeros, shared gains, outputs in the place of states.

structure                  which measurements each input may use
disturbed_plant            the plant with the disturbance and the output of the objective
sums, slack_matrix         the conditions of the convex steps
coordinates, joint_steps   one step: P for given gains, then P and gains together
descent_start              gains by descent on the norm itself
local_search               many steps from several starts
design, answer             ``structured_pdc`` and its result
"""
