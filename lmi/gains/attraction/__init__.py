"""Regions of attraction with limits: the largest ellipsoid from which a loop settles.

design               gains given or sought
condition, saturation    its LMIs; actuators that saturate
request              what is asked, checked on entry; where the ellipsoid may lie
set_size             what "largest" means
"""
