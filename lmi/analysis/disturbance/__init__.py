"""From disturbance to output of a given loop.

Energy gain (H-infinity), variance (H2), peak-to-peak gain.
"""
