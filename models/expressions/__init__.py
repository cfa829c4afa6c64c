"""Expressions as text, by a grammar that executes nothing.

tokens, parser   from text to sympy
lost_parts       parts that sympy folds away, and whether they have a value on the box
"""
