"""Small plants as the texts of their files; of the first the vertices are known by heart."""

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

NOISY_ROD = """
format = 1
kind = "plant"

[states]
x = { unit = "m", range = [-1, 1] }

[inputs]
u = { unit = "m/s" }

[disturbances]
gust = { unit = "cm/s" }
flow = { unit = "m/s", range = [-0.05, 0.05] }

[parameters]
a = { value = 1.0, unit = "1/s", source = "chosen" }
b = { value = 1.0, unit = "1/(m^2 s)", source = "chosen" }

[equations]
x = "a*x - b*x^3 + u + gust + flow"
"""

ROD = """
format = 1
kind = "plant"
units = "unchecked"

[states]
x = { range = [-1, 1] }

[inputs]
u = { range = [-4, 4] }

[equations]
x = "x - x^3 + u"
"""
