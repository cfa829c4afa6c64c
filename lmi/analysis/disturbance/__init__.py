"""Norms from disturbance to output of a given loop, each by one quadratic function.

energy_gain, bounded_real    energy gain (H-infinity); that of one vertex by its Riccati equation
output_variance, gramian     variance (H2); that of one vertex by its Lyapunov equation
peak_to_peak, peak_condition, reachable_set    peak-to-peak gain; its LMIs; that of one vertex
least_gain, channel          what all norms have in common; the path through the vertices
guessed_function             a guess of the function that shows a norm
"""
