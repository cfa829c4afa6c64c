"""A plant's equations about its equilibrium, before a model is made.

equations, step  f, g and A(z), ..., E(z) in symbols; one line of a derivation
problem          equations that vanish at the origin, box, names, premises
mass_matrix      from M(x) x' = f to x' = adj(M) f / det M
equilibrium      where a plant rests: checked exactly, or solved for its inputs
residuals        the residuals of the equations at rest, row by row
solved_rest, ball    a rest that was given in part, found; numbers that are not decimals
premise_units    units of premises, as far as the expressions determine them
symbolic_form    what a model was derived from, in symbols
"""
