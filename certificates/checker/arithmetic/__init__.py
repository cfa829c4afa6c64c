"""Intervals, functions and splines with outward rounding, on integers.

interval            intervals on integers over 10^36;  powers: their whole powers and roots
    dual                an interval with its partial derivatives
spline              ranges of a surface and its derivatives on such intervals
exponential         exp, alone;  monotone: increasing functions, from points to intervals
elementary, logarithm   sin, cos, atan, ...; log, erf, ... on intervals; lookup by name
effort_ramp         the ramp that shares one effort between two actuators
"""
