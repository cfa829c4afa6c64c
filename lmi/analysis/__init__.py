"""Conditions on a given loop, one in each file, with a builder that solves nothing."""
