"""Sweeps: what is proved of a turbine's law at each point of a grid of its parameters."""
