"""Candidates of claims about a turbine's loop, found in floating point."""
