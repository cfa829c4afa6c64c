"""Cubic and bicubic splines given by decimals.

curve, surface      interpolating splines of one and two arguments
scalar_surface fast evaluation at one point
exact_spline, bernstein_coefficients    exact values and rigorous ranges; the linear maps for them
patch_ranges        ranges in floats, for searches
table_function      a table as a function in sympy expressions
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.splines.surface import interpolate as interpolate
    from takagi.models.splines.table_function import TableFunction as TableFunction

__getattr__, __dir__ = lazy_names(__name__)
