"""Candidates of claims that are not separate requests. The checker decides about each.

turbine/    claims about a turbine's loop
plant/      all claims about a model or a plant with its gains: ``certify``
"""
