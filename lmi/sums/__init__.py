"""Double sums sum_ij h_i h_j Theta_ij as data, and the LMIs that make them negative."""
