"""A plant's equations about its equilibrium, before a model is made.

Mass matrix solved, inputs at equilibrium found, units of premises.
"""
