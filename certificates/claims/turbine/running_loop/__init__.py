"""Candidates for the coherent loop as it runs, with its observer, at constant winds.

signals     linear signals with uncertain factors, and the matrix of the decay inequality
running     the loop's factors enclosed over a box, and its equations as signals
candidate   a quadratic function for one cell of winds, with its inequalities in exact arithmetic

No claim is made of these yet: no checker replays them, so nothing here is PROVED.
"""
