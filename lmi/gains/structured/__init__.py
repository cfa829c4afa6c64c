"""Gains with a structure: zeros, shared gains, outputs in the place of states."""
