"""Conditions on a given loop, one in each file, with a builder that solves nothing.

common_quadratic, quadratic_condition    one P for all vertices, and its condition
norm_bounded               one P for uncertain models
decay_rate, slow_modes     the largest decay rate; single vertices that decay too slowly
impossibility              why there is no common P
pole_region                eigenvalues of every blend in a region of the complex plane
interval_matrices          interval families, without a list of their corners
invariant_ellipsoid        an ellipsoid that bounded disturbances do not leave
actuator_rates             how fast the inputs move: of a given law; as states of the model
loop_pairs                 the vertices of a loop under a law with memberships
disturbance/               norms from disturbance to output
"""
