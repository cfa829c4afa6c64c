"""The nonlinear plant, wind, and the closed loop in time."""
