"""Checks that a certificate is about the given gain, turbine or plant file."""
