"""Intervals, functions and splines with outward rounding, on integers.

fixed               intervals on integers over 2^96;  dual: such an interval and its slopes
spline              ranges of a surface and its derivatives on such intervals
decimal_interval    intervals on integers over 10^36
elementary, exponential   sin, cos, atan, ...; exp, log, erf, ... on decimal intervals
effort_ramp         the ramp by which two actuators share one effort
"""
