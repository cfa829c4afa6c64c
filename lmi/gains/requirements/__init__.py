"""What any gain design may be asked to keep, as double sums or LMIs.

given_limits    all that is asked, as the keywords of ``pdc`` give it
requirements    the checked part of it about plants and memberships
closed_loop     the closed loop as a double sum
limits          inputs and states on an ellipsoid, initial states inside it
rate_limits     how fast the inputs move
region_sums     eigenvalues in regions of the complex plane
robust_sums     norm-bounded uncertainty of the model
"""
