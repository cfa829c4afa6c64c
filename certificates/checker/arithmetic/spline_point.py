r"""Value and slopes of a bicubic B-spline at a point, exactly.

s(x, y) = sum_ij c_ij N_i(x) N_j(y), with N_{i,p} by the recursion of Cox and de Boor,

    N_{i,p} = (x - t_i)/(t_{i+p} - t_i) N_{i,p-1}
              + (t_{i+p+1} - x)/(t_{i+p+1} - t_{i+1}) N_{i+1,p-1}
    N_{i,p}' = p N_{i,p-1}/(t_{i+p} - t_i) - p N_{i+1,p-1}/(t_{i+p+1} - t_{i+1}) .

``spline`` encloses the same surface over rectangles, with a padding that a single point does not
need.

Source: de Boor (2001), A Practical Guide to Splines, ch. IX and X (recalled).
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.spline import DEGREE, Spline
from takagi.certificates.checker.kernel.reader import matrix, member, numbers
from takagi.certificates.checker.kernel.refusal import Refused

Row = list[Fraction]


@dataclass(frozen=True)
class ExactSurface:
    """The torque coefficient over tip-speed ratio and pitch, with the numbers of the file."""

    x_knots: Row
    y_knots: Row
    rows: list[Row]

    @classmethod
    def read(cls, model: Any) -> ExactSurface:
        """Return the surface of a turbine; refuses what ``Spline`` refuses."""
        table, where = member(model, "torque_surface", "model"), "model.torque_surface"
        x, y = (numbers(table, f"{axis}_knots", where) for axis in ("tip_speed_ratio", "pitch"))
        rows = matrix(table, "coefficients", where)
        Spline(x, y, rows)
        return cls(x, y, rows)

    def at(self, x: Fraction, y: Fraction) -> tuple[Fraction, Fraction, Fraction]:
        """Return s, ds/dx and ds/dy; refuses a point outside the table."""
        i, along_x, steep_x = _basis(self.x_knots, x)
        j, along_y, steep_y = _basis(self.y_knots, y)
        block = [row[j : j + DEGREE + 1] for row in self.rows[i : i + DEGREE + 1]]

        def value(left: Row, right: Row) -> Fraction:
            return sum(
                (a * _dot(row, right) for a, row in zip(left, block, strict=True)), Fraction(0)
            )

        return value(along_x, along_y), value(steep_x, along_y), value(along_x, steep_y)


def _basis(knots: Row, x: Fraction) -> tuple[int, Row, Row]:
    """Return the first of the four functions that act at x, their values and their slopes."""
    breaks = knots[DEGREE : len(knots) - DEGREE]
    if not breaks[0] <= x <= breaks[-1]:
        raise Refused("a point that leaves the coefficient table")
    # At the last knot the last cell counts.
    first = min(bisect_right(breaks, x) - 1, len(breaks) - 2)
    values, before = [Fraction(1)], [Fraction(1)]
    for p in range(1, DEGREE + 1):
        before, start = values, first + DEGREE - p
        values = []
        for i in range(start, start + p + 1):
            left, right = _share(before, i - start - 1), _share(before, i - start)
            total = Fraction(0)
            if left:
                total += (x - knots[i]) / (knots[i + p] - knots[i]) * left
            if right:
                total += (knots[i + p + 1] - x) / (knots[i + p + 1] - knots[i + 1]) * right
            values.append(total)
    slopes = []
    for k in range(DEGREE + 1):
        i, left, right = first + k, _share(before, k - 1), _share(before, k)
        slope = DEGREE * left / (knots[i + DEGREE] - knots[i]) if left else Fraction(0)
        if right:
            slope -= DEGREE * right / (knots[i + DEGREE + 1] - knots[i + 1])
        slopes.append(slope)
    return first, values, slopes


def _share(values: Row, place: int) -> Fraction:
    """Return the function of one degree less, which is 0 outside the cell's."""
    return values[place] if 0 <= place < len(values) else Fraction(0)


def _dot(left: Row, right: Row) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True)), Fraction(0))
