"""The design of a turbine's controller."""
