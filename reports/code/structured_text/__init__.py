"""IEC 61131-3 Structured Text: a function block with its gains as constants.

statements  formulas as statements: table look-ups become loops over constant arrays
block       the function block, and the target `st`
"""
