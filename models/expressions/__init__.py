"""Expressions as text.

A grammar that executes nothing, text to sympy and back, and evidence of proved ranges as JSON.
"""
