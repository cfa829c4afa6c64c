"""Double sums sum_ij h_i h_j Theta_ij as data, and the LMIs that make them negative.

double_sum, summands, weighted_sum   the sum itself, and its parts
membership_parts, membership_shape   matrices for each rule in it; what is known of the memberships
relaxations                          sufficient LMIs, by name
rule_pairs, slack_matrices           relaxations by pairs of rules, with slack matrices
product_premises, simplex_products   relaxations by products of memberships or of premise weights
relaxation_sizes                     the size of each, before it is built; which contains which
membership_points                    a condition that every relaxation must satisfy
corner_rules                         rules as corners of premises
"""
