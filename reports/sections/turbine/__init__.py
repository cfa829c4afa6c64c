"""The HTML report of a turbine design: one self-contained page, readable without JavaScript."""
