"""From a model, a plant or a turbine with its gains to claims. The checker decides about each.

certification   a model or a plant with gains: requests tried, claims checked; ``certify``
turbine/        candidates of claims about a turbine's loop
"""
