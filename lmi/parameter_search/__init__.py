"""The best value of a parameter in a condition.

largest_parameter    the largest or smallest value with a solution
parameter_path       an interior-point path towards that value
parameter_pencil     the largest value of the parameter that given unknowns allow
multiplier_bound     the values that the multipliers of a solver exclude
parameter_sweep      one condition solved at many values, assembled once
least_over_rate      the decay rate at which a bound is least
"""
