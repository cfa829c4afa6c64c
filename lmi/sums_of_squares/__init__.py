"""Polynomial Lyapunov functions by sums of squares, posed as LMIs."""
