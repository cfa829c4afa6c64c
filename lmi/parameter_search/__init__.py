"""The best value of a parameter in a condition.

largest_parameter    the largest or smallest value with a solution
parameter_path, parameter_pencil    a path to it; which value given unknowns allow
multiplier_bound     which values the multipliers exclude
parameter_sweep      many values, assembled once
least_over_rate      the decay rate at which a bound is least
"""
