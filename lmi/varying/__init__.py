"""A given loop, by Lyapunov functions that change with parameters or memberships.

constant_parameters, parameter_*    P polynomial in constant or moving parameters
varying_memberships, fuzzy_condition    memberships with bounds on their rates
membership_points    a function sought at single points of the memberships
robust_gain, answer_in_states    the norm; the answer
"""
