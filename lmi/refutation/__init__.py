"""A rigorous no: exact multipliers and functions that exclude every solution of a condition."""
