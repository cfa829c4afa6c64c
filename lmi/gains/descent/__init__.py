"""Gains by descent on the H-infinity norm itself, from many starts."""
