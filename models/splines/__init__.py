"""Cubic and bicubic splines given by decimals."""
