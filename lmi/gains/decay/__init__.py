"""Gains for a decay rate, by parallel distributed compensation."""
