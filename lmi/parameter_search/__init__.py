"""The best value of a parameter in a condition."""
