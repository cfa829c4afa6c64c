"""Gains of the effort-sharing law and the loop's quadratic functions, found together."""
