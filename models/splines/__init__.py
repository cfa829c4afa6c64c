"""Cubic and bicubic splines given by decimals.

Fast values, exact values, proved ranges, and tables as symbolic functions.
"""
