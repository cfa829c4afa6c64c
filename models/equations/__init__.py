"""A plant's equations about its equilibrium, before a model is made."""
