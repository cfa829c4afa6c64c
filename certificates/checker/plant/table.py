"""A table as a cubic spline of one argument, or a bicubic one of two, with values of any size."""

from __future__ import annotations

from bisect import bisect_right
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.arithmetic.interval import Interval
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.kernel.reader import matrix, member, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused

FLAT = [Fraction(k) for k in (0, 0, 0, 0, 1, 1, 1, 1)]  # a direction in which nothing changes
DEGREE = 3
# ``Spline`` computes on a grid of fixed step: coefficients of at most SIZE, and cells of at least
# CELL, keep its rounding small.
SIZE, CELL = Fraction(500), Fraction(1, 10)


class Table:
    """s(x) or s(x, y) = sum c N, clamped cubic B-splines over the knots of each argument.

    The spline is computed in units, scaled by powers of ten, in which its coefficients are below
    500 and its narrowest cell is 0.1 to 1 wide.
    """

    def __init__(self, knots: list[list[Fraction]], rows: list[list[Fraction]]) -> None:
        self.sides = [(axis[0], axis[-1]) for axis in knots]
        self._steps = [_cell_scale(axis) for axis in knots]
        largest = max((abs(c) for row in rows for c in row), default=Fraction(0))
        self._value = _power_of_ten(SIZE / largest) if largest else Fraction(1)
        axes = [[t * s for t in axis] for axis, s in zip(knots, self._steps, strict=True)]
        self.knots, self._rows = knots, rows
        if len(axes) == 1:
            axes, rows = [*axes, FLAT], [[row[0]] * 4 for row in rows]
        self._spline = Spline(axes[0], axes[1], [[c * self._value for c in row] for row in rows])

    @property
    def arguments(self) -> int:
        return len(self.sides)

    def exact(self, point: list[Fraction], orders: tuple[int, ...]) -> Fraction | None:
        """Return a partial derivative of order up to 2 at a point; None outside the table."""
        sides = zip(self.sides, point, strict=True)
        if any(not low <= value <= high for (low, high), value in sides):
            return None
        first_knot, knots = _near(self.knots[0], point[0])
        rows = self._rows[first_knot : first_knot + DEGREE + 1]
        column = [row[0] for row in rows]
        if len(point) == 2:
            first, other_knots = _near(self.knots[1], point[1])
            last = first + DEGREE + 1
            column = [at_point(other_knots, row[first:last], point[1], orders[1]) for row in rows]
        return at_point(knots, column, point[0], orders[0])

    def bounds(self, arguments: list[Interval], orders: tuple[int, ...]) -> Interval:
        """Return a bracket of a partial derivative over the part of a box inside the table.

        Parameters
        ----------
        arguments : their ranges; the caller must prove that they stay in the table.
        """
        fixed: list[Interval] = []
        axes = (self._spline.x, self._spline.y)
        for argument, axis, step in zip(arguments, axes, self._steps, strict=False):
            first, last = axis.breaks_fixed[0], axis.breaks_fixed[-1]
            down = max(argument[0] * step.numerator // step.denominator, first)
            up = min(-(-argument[1] * step.numerator // step.denominator), last)
            if down > last or up < first:
                raise Refused("an argument outside its table")
            fixed.append(Interval(min(down, up), max(down, up)))
        if len(fixed) == 1:
            fixed.append(Interval(0, 0))
        order = (*orders, 0)
        low_q, high_q = self._spline.bounds(fixed[0], fixed[1], order[0], order[1])
        scale = 1 / self._value
        for step, times in zip(self._steps, orders, strict=True):
            scale *= step**times
        low, high = low_q * scale, high_q * scale
        down = low.numerator // low.denominator
        return Interval(down, -(-high.numerator // high.denominator))


def _near(knots: list[Fraction], x: Fraction) -> tuple[int, list[Fraction]]:
    """Return the index of the first coefficient active at x, and the knots of the active ones."""
    first = min(bisect_right(knots, x) - 1, len(knots) - DEGREE - 2) - DEGREE
    return first, knots[first + 1 : first + 2 * DEGREE + 1]


def at_point(
    knots: list[Fraction], coefficients: list[Fraction], x: Fraction, order: int
) -> Fraction:
    """Return a derivative of a cubic piece by differences of coefficients and de Boor's recursion.

    Parameters
    ----------
    knots, coefficients : the six knots and the four coefficients that the value at x depends on.
    """
    p, d, u = DEGREE, coefficients, knots
    for _ in range(order):
        d = [p * (b - a) / (u[j + p] - u[j]) for j, (a, b) in enumerate(pairwise(d))]
        p, u = p - 1, u[1:-1]
    for level in range(1, p + 1):
        # From p - level + 1 points to one fewer; d[j] becomes that of j + level.
        d = [
            a + (b - a) * (x - u[j]) / (u[j + p + 1 - level] - u[j])
            for j, (a, b) in enumerate(pairwise(d), start=level - 1)
        ]
    return d[0]


def _cell_scale(axis: list[Fraction]) -> Fraction:
    """Return the power of ten that makes the narrowest cell 0.1 to 1 wide."""
    widths = [b - a for a, b in zip(axis, axis[1:], strict=False) if b > a]
    if not widths:
        raise CertificateError("knots that do not increase")
    return _power_of_ten(10 * CELL / min(widths))


def _power_of_ten(limit: Fraction) -> Fraction:
    """Return the greatest power of ten that does not exceed the limit > 0."""
    power = Fraction(1)
    while power > limit:
        power /= 10
    while 10 * power <= limit:
        power *= 10
    return power


def read_table(owner: dict[str, Any], name: str, where: str) -> Table:
    """Return a table of the file: ``knots``, one row for each argument, and ``coefficients``.

    Raises
    ------
    CertificateError : sizes do not fit, or knots are not clamped or do not increase.
    """
    table, table_place = member(owner, name, where), f"{where}.{name}"
    rows = member(table, "knots", table_place)
    if not isinstance(rows, list) or len(rows) not in (1, 2):
        raise CertificateError(f"{table_place}.knots: one or two rows are needed")
    knots = [numbers({"knots": row}, "knots", table_place) for row in rows]
    if len(knots) == 1:
        coefficients = [[c] for c in numbers(table, "coefficients", table_place)]
    else:
        coefficients = matrix(table, "coefficients", table_place)
    return Table(knots, coefficients)
