"""Gains together with a Lyapunov function that depends on the memberships."""
