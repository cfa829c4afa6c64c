"""Candidates of claims that are no request of their own.  The checker decides about each.

turbine/    claims about a turbine's loop
plant/      all that is claimed of a model or a plant with its gains: ``certify``
"""
