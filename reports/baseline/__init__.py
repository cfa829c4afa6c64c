"""Comparison of a certificate with an earlier one: worse figures, lost claims, changed inputs."""
