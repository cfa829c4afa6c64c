"""IEC 61131-3 Structured Text: a function block with its gains as constants.

words       keywords and functions of the standard, and formulas for functions that it lacks
statements  formulas as statements: table look-ups become loops over constant arrays
block       the function block, and the target `st`
"""
