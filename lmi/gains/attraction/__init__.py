"""Regions of attraction with limits: the largest ellipsoid from which a loop settles.

design      gains given or sought;  condition  its LMIs;  saturation  actuators that saturate
box, task   where the ellipsoid may lie, checked at the door
search, largest_set    what "largest" means, and how it is found
"""
