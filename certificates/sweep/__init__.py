"""Sweeps: what is proved of a turbine's law at each point of a grid of its parameters.

tasks             tasks over several processes, with one stored result each: ``run_tasks``
axis              a quantity with its values, and how a user writes it
effort_sharing    one point of the effort-sharing law
published         one point of a published law: a pair of overlaps, at many winds
sweep             all points of a grid: ``run_sweep``
"""
