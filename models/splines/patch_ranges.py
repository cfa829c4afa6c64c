r"""Ranges of a bicubic surface and its derivatives over rectangles, in floating point, fast.

On each knot cell the surface is a polynomial; its Bernstein coefficients on the part of the cell
that the rectangle covers bound it (Lane and Riesenfeld 1981).  The same bound as
``exact_spline`` up to rounding, a hundred times faster: for searching, not for proving.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from functools import lru_cache
from math import comb, perm

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.dual import Range
from takagi.models.splines.scalar_surface import patch_coefficients
from takagi.models.splines.surface import Surface

DEGREE = 3
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
        found = []
        for dx, dy in orders:
            nets = [
                left @ self._patches[i, j] @ right.T
                for i, left in along[dx]
                for j, right in across[dy]
            ]
            low, high = min(float(n.min()) for n in nets), max(float(n.max()) for n in nets)
            found.append((low, high))
        return found


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
            ways = range(max(0, m - (n - i)), min(i, m) + 1)
            total = sum(comb(i, j) * comb(n - i, m - j) * b**j * a ** (m - j) for j in ways)
            rows[i, m + order] = perm(m + order, order) * total / comb(n, m)
    return rows
