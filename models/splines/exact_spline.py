r"""Exact values and rigorous ranges of a bicubic spline given by decimals.

On one cell of the knot grid a bicubic spline, and each partial derivative of it, is a polynomial.
Written in Bernstein form on a rectangle,

    p(s, t) = \sum_{ij} b_ij B_i(s) B_j(t),     B_i >= 0,  \sum_i B_i = 1,

so min b_ij <= p <= max b_ij there, and the corner coefficients are values of p.  The map from the
B-spline coefficients C of a cell to the b_ij of a derivative on a sub-rectangle is linear in each
direction, b = X C Y', with rational X and Y.  X and Y are kept as integers over one denominator
and C as integers over a power of ten, so every number here is exact: there is no rounding to
bound, and the range over a box is the union of the ranges over the cells that the box meets.
Their entries are values of the blossom, the polar form of a polynomial, evaluated by de Boor's
recursion with a different argument at each level.

Source: Lane and Riesenfeld (1981), "Bounds on a polynomial", BIT 21 (range from Bernstein
coefficients); Ramshaw (1989), "Blossoms are polar forms" (conversion and restriction).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from operator import mul

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Rows = tuple[tuple[int, ...], ...]
DEGREE = 3
MAX_ORDER = 2  # second derivatives are the last continuous ones


# A point given in other units lands on the edge only up to rounding: 30 deg is 3e-13 rad
# outside a knot of 12 decimals.  Points that far outside are moved to the edge; points further
# outside are refused.
EDGE = 1e-9


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
    last_interval, parts_found = axis.latest.get(order, (None, []))
    if last_interval is not where:
        parts_found = _parts(axis, where, order)
        axis.latest[order] = where, parts_found
    return parts_found


def _parts(axis: KnotAxis, where: Interval, order: int) -> list[tuple[int, AxisMap]]:
    if where.lower < axis.lower or where.upper > axis.upper:
        raise ModelError(
            f"{where} leaves the spline's range "
            f"[{float(axis.lower):.9g}, {float(axis.upper):.9g}]; shrink the box"
        )
    maps = []
    # Only spans that the interval meets; one that ends where it begins is met in a point.
    first = max(0, bisect_left(axis.starts, where.lower) - 1)
    for span in axis.spans[first : bisect_right(axis.starts, where.upper)]:
        start, end = axis.knots[span], axis.knots[span + 1]
        low, high = max(start, where.lower), min(end, where.upper)
        if low < high or (low == high and where.width == 0):
            span_map = axis.maps[span, order]
            if low == start and high == end:
                maps.append((span, span_map))
            else:
                maps.append(
                    (
                        span,
                        _restricted(
                            span_map, (low - start) / (end - start), (high - start) / (end - start)
                        ),
                    )
                )
            if where.width == 0:
                break  # both neighbours of a knot agree there: orders up to 2 are continuous
    return maps


def _restricted(span_map: AxisMap, s: Fraction, t: Fraction) -> AxisMap:
    """Return the map for the part [s, t] of a span, 0 <= s <= t <= 1.

    Row k of the restriction holds the blossom weights at (s, ..., s, t, ..., t) with k times t:
    the coefficients of prod_r ((1 - u_r) + u_r z).  Over the common denominator of s and t they
    are integers.
    """
    degree = len(span_map.rows) - 1
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
    return AxisMap(times(tuple(rows), span_map.rows), span_map.denominator * unit**degree)


def times(first: Rows, second: Rows) -> Rows:
    """Return the product of two integer matrices."""
    return times_columns(first, tuple(zip(*second, strict=True)))


def times_columns(rows: Sequence[Sequence[int]], columns: Rows) -> Rows:
    """Return the product of two integer matrices, the second given by its columns."""
    if len({*map(len, rows), *map(len, columns)}) > 1:
        raise ValueError("matrices that do not fit were given to a product")
    return tuple(tuple(sum(map(mul, row, column)) for column in columns) for row in rows)


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


@dataclass(frozen=True, slots=True)
class ExactSpline:
    """A bicubic spline in exact numbers: two axes, and coefficients / scale as integers."""

    x: KnotAxis
    y: KnotAxis
    coefficients: Rows
    scale: int
    # Hulls of whole cells: (span in x, span in y, order in x, order in y) -> hull.
    hulls: dict[tuple[int, int, int, int], Interval] = field(
        default_factory=dict, repr=False, compare=False
    )


def exact_spline(
    x_knots: tuple[Fraction, ...], y_knots: tuple[Fraction, ...], coefficients: Rows, scale: int
) -> ExactSpline:
    """Return the spline with those full knot vectors and coefficients[i][j] / scale."""
    return ExactSpline(axis_of(x_knots), axis_of(y_knots), coefficients, scale)


def exact_bounds(
    spline: ExactSpline, x: Interval, y: Interval, dx: int = 0, dy: int = 0
) -> Interval:
    """Return an interval that contains d^(dx+dy) s / dx^dx dy^dy over the rectangle x times y.

    It is the union of the Bernstein hulls of the cells.

    ``dx``, ``dy`` : orders 0, 1 or 2.

    Raises
    ------
    ModelError : order out of range, or the rectangle leaves the knots.
    """
    for order in (dx, dy):
        if order not in range(MAX_ORDER + 1):
            raise ModelError(f"derivative order {order} was given; 0, 1 or 2 is needed")
    hulls = _hulls(spline, x, y, dx, dy)
    return Interval(min(h.lower for h in hulls), max(h.upper for h in hulls))


def exact_value(
    spline: ExactSpline, x: Fraction, y: Fraction, dx: int = 0, dy: int = 0
) -> Fraction:
    """Return the value of a partial derivative at one point, exactly."""
    point = exact_bounds(spline, Interval(x, x), Interval(y, y), dx, dy)
    return point.lower


def _hulls(spline: ExactSpline, x: Interval, y: Interval, dx: int, dy: int) -> list[Interval]:
    """Return the hull of each cell that the rectangle meets; those of whole cells are made once."""
    columns = pieces(spline.y, y, dy)
    hulls = []
    for x_span, x_map in pieces(spline.x, x, dx):
        whole_x = x_map is spline.x.maps[x_span, dx]
        for y_span, y_map in columns:
            key = (x_span, y_span, dx, dy)
            whole_cell = whole_x and y_map is spline.y.maps[y_span, dy]
            hull = spline.hulls.get(key) if whole_cell else None
            if hull is None:
                hull = _hull(spline, x_span, x_map, y_span, y_map)
            if whole_cell:
                spline.hulls[key] = hull
            hulls.append(hull)
    return hulls


def _hull(
    spline: ExactSpline, x_span: int, x_map: AxisMap, y_span: int, y_map: AxisMap
) -> Interval:
    """Return [min, max] of the Bernstein coefficients X C Y' of a cell, or a mapped part of it."""
    local = tuple(
        row[y_span - DEGREE : y_span + 1]
        for row in spline.coefficients[x_span - DEGREE : x_span + 1]
    )
    rows = times_columns(times(x_map.rows, local), y_map.rows)
    unit = x_map.denominator * y_map.denominator * spline.scale
    return Interval(Fraction(min(map(min, rows)), unit), Fraction(max(map(max, rows)), unit))


def points_inside(
    name: str, axis: str, values: ArrayLike, covered: tuple[float, float], clip: bool
) -> Floats:
    """Return points of a table, those beyond its edge moved there.

    Raises
    ------
    ModelError : a NaN, or a point outside the table without ``clip``.
    """
    array = np.asarray(values, dtype=np.float64)
    low, high = covered
    slack = np.inf if clip else EDGE
    good = (array >= low - slack) & (array <= high + slack)
    if not good.all():
        raise ModelError(
            f"{name}: {axis} = {array[~good].flat[0]:.9g} is outside the table, "
            f"{low:.9g} to {high:.9g}; stay inside, extend the table, or ask for clip=True"
        )
    return np.asarray(np.minimum(np.maximum(array, low), high), dtype=np.float64)


def require_inside(name: str, axis: str, side: Interval, covered: KnotAxis) -> None:
    """Raise ModelError unless a range of arguments lies in the table."""
    if side.lower < covered.lower or side.upper > covered.upper:
        raise ModelError(
            f"{name}: {axis} in {side} leaves the table, {float(covered.lower):.9g} to "
            f"{float(covered.upper):.9g}; extend the table or shrink the box"
        )
