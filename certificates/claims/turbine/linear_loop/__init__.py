"""Candidates of claims about the turbine's loop linearised at one wind, in turbulence.

crossing_search         covariances on pieces of the parameters' box
turbine_crossing_claim  the claims at some mean winds (``turbine-crossing``)
"""
