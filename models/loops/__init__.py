"""Closed loops as families of matrices: turbine and law enclosed together, one family a wind cell.

effort_sharing/    the loop with the effort-sharing law
published/         the loop with a published law
"""
