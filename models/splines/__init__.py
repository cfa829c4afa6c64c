"""Cubic and bicubic splines given by decimals.

curve, surface      interpolating splines of one and two arguments
scalar_surface      one point at a time, cheaply
exact_spline, bernstein_coefficients    exact values and rigorous ranges; the maps behind them
patch_ranges, approximate_ranges    ranges in floats, for searching
table_function      a table as a function in sympy expressions
"""
