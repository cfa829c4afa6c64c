"""Norms from disturbance to output of a given loop, each by one quadratic function."""
