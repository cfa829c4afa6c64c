"""A given loop, by Lyapunov functions that change with parameters or memberships."""
