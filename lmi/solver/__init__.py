"""From a condition to numbers that withstand their check; the only calls of a solver.

assemble      cone data, vectorised: one PSD triangle per item
solve         the programs and the solvers that are tried, one after another
stages        decide (largest margin), optimise, improve, re-centre
vertex_rounds    many vertices: few are given to the solver, all are looked at
balance       coordinates in which the numbers are of order one
diagnosis     which items bind, in words
"""
