"""Takagi-Sugeno models as values.

model             TSModel: matrices, premises, rules, and the box they hold on
premise           a premise variable with its proved range
vertex_matrices, vertex_arrays, vertex_product    its matrices: stored whole or by entry, checked
derivation        the derivation that a model came from, in LaTeX
"""
