"""Gains for a decay rate, by parallel distributed compensation.

pdc                one gain a rule, one Lyapunov function for all
request, condition, design    what is asked; the LMIs; gains in the model's units, or a no
largest_rate       the largest rate with gains
relaxation_search, relaxation_table    one relaxation after another; what each costs and buys
limited_outcome    whether a no is one of the limits
"""
