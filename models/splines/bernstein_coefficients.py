"""Exact linear maps from the B-spline coefficients of a knot span to Bernstein coefficients.

There is one map for each direction, span, part of the span and order of differentiation: an integer
matrix over one denominator. Its entries are values of the blossom, the polar form of a polynomial,
evaluated by de Boor's recursion with a different argument at each level.

Source: Ramshaw (1989), "Blossoms are polar forms", Computer Aided Geometric Design 6.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from operator import mul

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Rows = tuple[tuple[int, ...], ...]
DEGREE = 3
MAX_ORDER = 2  # second derivatives are the last continuous ones


@dataclass(frozen=True, slots=True)
class AxisMap:
    """Integer matrix over one denominator: four B-spline coefficients to Bernstein coefficients."""

    rows: Rows
    denominator: int


@dataclass(frozen=True, slots=True)
class KnotAxis:
    """Knots of one direction with, per non-empty span and order, the map for the whole span."""

    knots: tuple[Fraction, ...]
    spans: tuple[int, ...]
    starts: tuple[Fraction, ...]  # where each span begins
    maps: dict[tuple[int, int], AxisMap]
    # The last interval for each order, and its parts: the derivatives of a surface over one
    # rectangle need the same ones.
    latest: dict[int, tuple[Interval, list[tuple[int, AxisMap]]]] = field(
        default_factory=dict, repr=False, compare=False
    )

    @property
    def lower(self) -> Fraction:
        return self.knots[DEGREE]

    @property
    def upper(self) -> Fraction:
        return self.knots[-DEGREE - 1]


def pieces(axis: KnotAxis, where: Interval, order: int) -> list[tuple[int, AxisMap]]:
    """Return (span, map) for the parts of ``where`` in each knot span."""
    asked, found = axis.latest.get(order, (None, []))
    if asked is not where:
        found = _parts(axis, where, order)
        axis.latest[order] = where, found
    return found


def _parts(axis: KnotAxis, where: Interval, order: int) -> list[tuple[int, AxisMap]]:
    if where.lower < axis.lower or where.upper > axis.upper:
        raise ModelError(
            f"{where} leaves the spline's range "
            f"[{float(axis.lower):.9g}, {float(axis.upper):.9g}]; shrink the box"
        )
    found = []
    # Only spans that the interval meets; one that ends where it begins is met in a point.
    first = max(0, bisect_left(axis.starts, where.lower) - 1)
    for span in axis.spans[first : bisect_right(axis.starts, where.upper)]:
        start, end = axis.knots[span], axis.knots[span + 1]
        low, high = max(start, where.lower), min(end, where.upper)
        if low < high or (low == high and where.width == 0):
            whole = axis.maps[span, order]
            if low == start and high == end:
                found.append((span, whole))
            else:
                found.append(
                    (
                        span,
                        _restricted(
                            whole, (low - start) / (end - start), (high - start) / (end - start)
                        ),
                    )
                )
            if where.width == 0:
                break  # both neighbours of a knot agree there: orders up to 2 are continuous
    return found


def _restricted(whole: AxisMap, s: Fraction, t: Fraction) -> AxisMap:
    """Return the map for the part [s, t] of a span, 0 <= s <= t <= 1.

    Row k of the restriction holds the blossom weights at (s, ..., s, t, ..., t) with k times t:
    the coefficients of prod_r ((1 - u_r) + u_r z).  Over the common denominator of s and t they
    are integers.
    """
    degree = len(whole.rows) - 1
    unit = lcm(s.denominator, t.denominator)
    low, high = int(s * unit), int(t * unit)
    rows = []
    for k in range(degree + 1):
        weights = [1]
        for u in [low] * (degree - k) + [high] * k:
            up = [0, *(u * w for w in weights)]
            stay = [*((unit - u) * w for w in weights), 0]
            weights = [a + b for a, b in zip(up, stay, strict=True)]
        rows.append(tuple(weights))
    return AxisMap(times(tuple(rows), whole.rows), whole.denominator * unit**degree)


def times(left: Rows, right: Rows) -> Rows:
    """Return the product of two integer matrices."""
    return times_columns(left, tuple(zip(*right, strict=True)))


def times_columns(left: Sequence[Sequence[int]], columns: Rows) -> Rows:
    """Return the product of two integer matrices, the second given by its columns."""
    if len({*map(len, left), *map(len, columns)}) > 1:
        raise ValueError("matrices that do not fit were given to a product")
    return tuple(tuple(sum(map(mul, row, column)) for column in columns) for row in left)


def axis_of(knots: tuple[Fraction, ...]) -> KnotAxis:
    """Return the axis with those full knots, its whole-span maps computed."""
    spans = tuple(i for i in range(DEGREE, len(knots) - DEGREE - 1) if knots[i] < knots[i + 1])
    maps = {
        (span, order): _span_map(knots, span, order)
        for span in spans
        for order in range(MAX_ORDER + 1)
    }
    return KnotAxis(knots, spans, tuple(knots[span] for span in spans), maps)


def _span_map(knots: tuple[Fraction, ...], span: int, order: int) -> AxisMap:
    """Return the map to the Bernstein coefficients of the order-th derivative on one span.

    c_j <- q (c_j - c_{j-1}) / (t_{j+q} - t_j) lowers degree q by differentiation; the Bernstein
    coefficients of what is left are its blossom at the span's ends.
    """
    vectors = {
        span - DEGREE + k: tuple(Fraction(int(k == m)) for m in range(DEGREE + 1))
        for k in range(DEGREE + 1)
    }
    for q in range(DEGREE, DEGREE - order, -1):
        vectors = {
            j: _combined(
                vectors[j - 1],
                vectors[j],
                -q / (knots[j + q] - knots[j]),
                q / (knots[j + q] - knots[j]),
            )
            for j in range(span - q + 1, span + 1)
        }
    degree = DEGREE - order
    ends = knots[span], knots[span + 1]
    rows = [
        _blossom(knots, span, vectors, [ends[0]] * (degree - k) + [ends[1]] * k)
        for k in range(degree + 1)
    ]
    unit = lcm(*(entry.denominator for row in rows for entry in row))
    return AxisMap(tuple(tuple(int(entry * unit) for entry in row) for row in rows), unit)


def _blossom(
    knots: tuple[Fraction, ...],
    span: int,
    vectors: dict[int, tuple[Fraction, ...]],
    arguments: list[Fraction],
) -> tuple[Fraction, ...]:
    """Return de Boor's recursion with a different argument at each level."""
    degree = len(arguments)
    current = dict(vectors)
    for level, u in enumerate(arguments, start=1):
        for j in range(span, span - degree + level - 1, -1):
            low, high = knots[j], knots[j + degree - level + 1]
            share = (u - low) / (high - low)
            current[j] = _combined(current[j - 1], current[j], 1 - share, share)
    return current[span]


def _combined(
    first: tuple[Fraction, ...], second: tuple[Fraction, ...], alpha: Fraction, beta: Fraction
) -> tuple[Fraction, ...]:
    return tuple(alpha * a + beta * b for a, b in zip(first, second, strict=True))
