"""Conditions about a given loop, one a file: each has a builder that solves nothing."""
