"""From a model or a plant and its gains to a certificate.

certification       a model with gains: requests tried, claims checked; ``certify``
certificate         a plant with its law: every claim that was asked for
sampled_premises    refuses bounds that are based on samples
"""
