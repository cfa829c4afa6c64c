"""From a model or a plant and its gains to a certificate.

certification       a model with gains: requests tried, claims checked; sampled bounds refused
certificate         a plant with its law: every claim that was asked for
useful_overshoot    of the proved bounds of an overshoot the best, or none
"""
