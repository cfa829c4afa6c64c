r"""A bicubic surface in floating point, fast: values at one point, ranges over rectangles.

Every knot cell of the spline is a polynomial sum_pq c_pq (x - x_i)^p (y - y_j)^q; its sixteen
coefficients are computed once, then evaluated by Horner's rule on Python floats.  About thirty
times faster than the vectorised call on a single point, and equal to it within rounding.

The Bernstein coefficients on the part of the cell that a rectangle covers bound the polynomial
(Lane and Riesenfeld 1981): the same bound as ``exact_spline`` up to rounding, a hundred times
faster, for searching and not for proving.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from functools import lru_cache
from math import comb, factorial, perm

import numpy as np
from scipy.interpolate import BSpline

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Range
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
    spline = BSpline(knots, values, DEGREE)
    lower = knots[DEGREE : len(knots) - DEGREE - 1]
    return np.stack([spline(lower, nu=power) / factorial(power) for power in range(DEGREE + 1)])


Matrix = Floats


class PatchRanges:
    """Bernstein ranges of one surface."""

    def __init__(self, surface: Surface) -> None:
        x, y, self._patches = patch_coefficients(surface)
        self._x, self._y = x.tolist(), y.tolist()

    def __call__(self, x: Range, y: Range, orders: tuple[tuple[int, int], ...]) -> list[Range]:
        """Return the range of each derivative (dx, dy) over the rectangle.

        Raises
        ------
        ModelError : the rectangle leaves the table.
        """
        along = {d: list(_pieces(self._x, x, d)) for d in {order[0] for order in orders}}
        across = {d: list(_pieces(self._y, y, d)) for d in {order[1] for order in orders}}
        ranges = []
        for dx, dy in orders:
            nets = [
                along_x @ self._patches[i, j] @ along_y.T
                for i, along_x in along[dx]
                for j, along_y in across[dy]
            ]
            low, high = min(float(n.min()) for n in nets), max(float(n.max()) for n in nets)
            ranges.append((low, high))
        return ranges


@lru_cache(maxsize=4)
def patch_ranges(surface: Surface) -> PatchRanges:
    """Return the ranges of a surface; made once per surface."""
    return PatchRanges(surface)


def _pieces(knots: list[float], over: Range, order: int) -> Iterator[tuple[int, Matrix]]:
    low, high = over
    if not (knots[0] <= low <= high <= knots[-1]):
        raise ModelError(
            f"range {low:.6g} to {high:.6g} leaves the coefficient table, {knots[0]:.6g} to "
            f"{knots[-1]:.6g}; take a smaller box"
        )
    last = len(knots) - 2
    first = min(max(bisect_right(knots, low) - 1, 0), last)
    final = min(max(bisect_left(knots, high) - 1, first), last)
    for i in range(first, final + 1):
        start, stop = max(low, knots[i]) - knots[i], min(high, knots[i + 1]) - knots[i]
        yield i, _bernstein(start, stop, order)


def _bernstein(a: float, b: float, order: int) -> Matrix:
    """Return the map from power coefficients to Bernstein ones of a derivative on [a, b].

    The ordinate i of t^m in degree n is its polar form at n - i times a and i times b.
    """
    n = DEGREE - order
    rows = np.zeros((n + 1, DEGREE + 1))
    for i in range(n + 1):
        for m in range(n + 1):
            indices = range(max(0, m - (n - i)), min(i, m) + 1)
            total = sum(comb(i, j) * comb(n - i, m - j) * b**j * a ** (m - j) for j in indices)
            rows[i, m + order] = perm(m + order, order) * total / comb(n, m)
    return rows
