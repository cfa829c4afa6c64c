"""A given loop, by Lyapunov functions that change with parameters or memberships.

constant_parameters, parameter_*    P polynomial in constant or moving parameters
varying_memberships, fuzzy_condition, rate_polytopes    memberships with bounds on their rates
membership_points    a function sought at single points of the memberships
lyapunov_forms, robust_gain, answer_in_states    the two forms of decrease; the norm; the answer
"""
