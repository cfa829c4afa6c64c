"""Expressions as text, by a grammar that executes nothing.

tokens, parser   from text to sympy
writer           and back, so that it can be read again
lost_parts       parts that sympy folds away, and whether they have a value on the box
evidence_file    evidence of a proved range as JSON
"""
