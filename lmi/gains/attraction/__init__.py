"""Regions of attraction with limits: the largest ellipsoid from which a loop settles.

design               gains given or sought
condition, saturation    its LMIs; actuators that saturate
request, state_box   what is asked, checked on entry; where the ellipsoid may lie
search, set_size     how the largest is found, and what "largest" means
"""
