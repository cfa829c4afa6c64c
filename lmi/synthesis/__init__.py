"""Conditions about gains that are sought, one a file, and the double sums they are made of.

closed_loop     the loop of a law u = -sum_j h_j K_j x, continuous and discrete
double_sum      sum_ij h_i h_j Theta_ij as data
relaxations     sufficient LMIs for such a sum, by name
limits          on inputs, states and gains, as LMIs
"""
