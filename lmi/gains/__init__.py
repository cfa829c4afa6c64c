"""Gains that are sought, one question a file: decay, regions, limits, cost, observers.

compensation, compensation_*   parallel distributed compensation: called, posed, solved
closed_loop                    the loop of u = -sum_j h_j K_j x, continuous and discrete
demands, limits, rate_limits   what a design must do besides decaying
region_sums, uncertainty       regions of the complex plane and uncertain models, as double sums
ladder, climb, largest_rate, shown_rate    one relaxation after another; the largest decay rate
regulator, cost_condition, guaranteed_cost    the linear-quadratic regulator
observation, secant_family     observers, also with premises that are not measured

The sums and their relaxations are in ``sums``; gains against disturbances, with regions of
attraction, fuzzy functions and structure have rooms of their own beside this one.
"""
