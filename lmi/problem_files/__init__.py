"""Conic problems in files of other programs: SDPA, CBF, SeDuMi's MAT and cvxpy's data."""
