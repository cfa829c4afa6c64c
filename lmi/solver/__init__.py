"""From a condition to numbers that withstand their check; the only calls of a solver.

assemble      cone data, vectorised: one PSD triangle per item
program       the cone program, and what a solver returns
solve         the solvers that are tried, one after another; sdpa_solver, cvxpy_solvers are others
choice, incidence, elimination    which is first, and explicit zeros that make clarabel quicker
duality       bounds on the optimum from multipliers
judging       a solver's numbers, checked; contradiction, multiplier_equalities: what a no rests on
stages, outcome    decide (largest margin), optimise, improve, re-centre
parameter_sweep    one condition at many parameter values, assembled once
item_rounds, vertex_rounds    many items: few are given to the solver, all are looked at
largest_parameter    the largest or smallest value of a parameter: generalised eigenvalues
parameter_pencil, parameter_path, multiplier_bound    what that is made of
balance       coordinates in which the numbers are of order one
diagnosis     which items bind, in words
"""
