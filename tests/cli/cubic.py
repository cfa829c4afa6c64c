"""A plant whose vertices are known by heart, as a file's text."""

from __future__ import annotations

CUBIC = """
format = 1
kind = "plant"
units = "unchecked"
name = "cubic"

[states]
x = { range = [-1, 1] }

[inputs]
u = {}

[equations]
x = "x + x^3 + u"
"""
