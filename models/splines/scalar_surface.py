r"""A bicubic surface in floating point, fast, at one point.

Every knot cell of the spline is a polynomial sum_pq c_pq (x - x_i)^p (y - y_j)^q; its sixteen
coefficients are computed once, then evaluated by Horner's rule on Python floats.  About thirty
times faster than the vectorised call on a single point, and equal to it within rounding.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import lru_cache
from math import factorial

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.splines.spline import Surface

DEGREE = 3
ScalarSurface = Callable[[float, float], float]


def patch_coefficients(surface: Surface) -> tuple[Floats, Floats, Floats]:
    """Return (x corners, y corners, c) with s = sum_pq c[i, j, p, q] (x - x_i)^p (y - y_j)^q.

    Shapes: (mx + 1,), (my + 1,), (mx, my, 4, 4) for mx times my knot cells.

    Source: de Boor (1978), A Practical Guide to Splines, ch. X (from B- to pp-form).
    """
    along_x = _power_form(surface.x_knots, surface.coefficients)
    x_cells, ny = along_x.shape[1], along_x.shape[2]
    flat = along_x.reshape(DEGREE + 1, x_cells, ny).transpose(2, 0, 1).reshape(ny, -1)
    along_y = _power_form(surface.y_knots, flat)
    y_cells = along_y.shape[1]
    patches = along_y.reshape(DEGREE + 1, y_cells, DEGREE + 1, x_cells)
    corners_x = surface.x_knots[DEGREE : len(surface.x_knots) - DEGREE]
    corners_y = surface.y_knots[DEGREE : len(surface.y_knots) - DEGREE]
    return corners_x, corners_y, np.ascontiguousarray(patches.transpose(3, 1, 2, 0))


@lru_cache(maxsize=16)
def scalar_surface(surface: Surface) -> ScalarSurface:
    """Return f(x, y) on Python floats; a point outside the table is moved to its edge.

    Nothing is raised, and NaN is not checked for. To know whether a point was outside, compare it
    with ``surface.x_range`` and ``surface.y_range``.
    """
    corners_x, corners_y, patches = patch_coefficients(surface)
    x_knots, y_knots = corners_x.tolist(), corners_y.tolist()
    inner_x, inner_y = x_knots[1:-1], y_knots[1:-1]
    x_low, x_high, y_low, y_high = x_knots[0], x_knots[-1], y_knots[0], y_knots[-1]
    rows, columns = patches.shape[:2]
    cells: list[list[tuple[float, ...]]] = [
        [tuple(patches[i, j].ravel().tolist()) for j in range(columns)] for i in range(rows)
    ]

    def evaluate(x: float, y: float) -> float:
        x = x_low if x < x_low else x_high if x > x_high else x
        y = y_low if y < y_low else y_high if y > y_high else y
        i, j = bisect_right(inner_x, x), bisect_right(inner_y, y)
        a, b, c, d, e, f, g, h, k, m, n, o, p, q, r, s = cells[i][j]
        x -= x_knots[i]
        y -= y_knots[j]
        return (
            a + y * (b + y * (c + y * d))
            + x * (e + y * (f + y * (g + y * h))
            + x * (k + y * (m + y * (n + y * o))
            + x * (p + y * (q + y * (r + y * s)))))
        )  # fmt: skip

    return evaluate


def _power_form(knots: Floats, values: Floats) -> Floats:
    """Return (power, cell, column) Taylor coefficients at the lower corner of every cell."""
    from scipy.interpolate import BSpline

    spline = BSpline(knots, values, DEGREE)
    lower = knots[DEGREE : len(knots) - DEGREE - 1]
    return np.stack([spline(lower, nu=power) / factorial(power) for power in range(DEGREE + 1)])
