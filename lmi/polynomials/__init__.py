"""Matrix polynomials in memberships: known and unknown coefficients, and a Lyapunov matrix P(h)."""
