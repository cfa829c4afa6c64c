"""Regions of attraction with limits: the largest ellipsoid from which a loop settles.

design               gains given or sought; how the largest is found
condition, saturation    its LMIs, and what "largest" means; actuators that saturate
request              what is asked, checked on entry; where the ellipsoid may lie
"""
