"""Gains against disturbances: energy gain (H-infinity), variance (H2), peak-to-peak."""
