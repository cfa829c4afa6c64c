"""Regions of attraction with limits: the largest ellipsoid from which a loop settles."""
