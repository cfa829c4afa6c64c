"""From a condition to an answer that passes an independent check.

decide                       feasible or not, the best objective, a better centre
outcome, answer_check        the best of a solver's tries, a no in words; check of its numbers
item_rounds, vertex_rounds   very many items or vertices: the solver is given few, all are checked
"""
