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

import heapq
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count
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


MAX_SPLITS = 20_000  # per end; reaching it returns a valid, less tight bound


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


@dataclass(frozen=True, slots=True)
class Patch:
    """Bernstein coefficients ``rows`` / ``denominator`` of a polynomial on a rectangle."""

    rows: Rows
    denominator: int

    def hull(self) -> Interval:
        """Return [min, max] of the coefficients: contains the range."""
        low = min(min(row) for row in self.rows)
        high = max(max(row) for row in self.rows)
        return Interval(Fraction(low, self.denominator), Fraction(high, self.denominator))

    def corners(self) -> Interval:
        """Return [min, max] over the four corner values: lies inside the range."""
        values = [self.rows[i][j] for i in (0, -1) for j in (0, -1)]
        return Interval(
            Fraction(min(values), self.denominator), Fraction(max(values), self.denominator)
        )


def exact_spline(
    x_knots: tuple[Fraction, ...], y_knots: tuple[Fraction, ...], coefficients: Rows, scale: int
) -> ExactSpline:
    """Return the spline with those full knot vectors and coefficients[i][j] / scale."""
    return ExactSpline(axis_of(x_knots), axis_of(y_knots), coefficients, scale)


def exact_bounds(
    spline: ExactSpline,
    x: Interval,
    y: Interval,
    dx: int = 0,
    dy: int = 0,
    *,
    tolerance: Fraction | None = None,
) -> Interval:
    """Return an interval that contains d^(dx+dy) s / dx^dx dy^dy over the rectangle x times y.

    Parameters
    ----------
    dx, dy : orders 0, 1 or 2.
    tolerance : None takes the union of the Bernstein hulls.  A fraction w > 0 bisects cells
        until each end is within w times the width of the range (of what is known of it so far).

    Raises
    ------
    ModelError : order out of range, or the rectangle leaves the knots.
    """
    for order in (dx, dy):
        if order not in range(MAX_ORDER + 1):
            raise ModelError(f"derivative order {order} was given; 0, 1 or 2 is needed")
    if tolerance is None:
        hulls = _hulls(spline, x, y, dx, dy)
        return Interval(min(h.lower for h in hulls), max(h.upper for h in hulls))
    if tolerance <= 0:
        raise ModelError(f"tolerance {tolerance} was given; a number > 0 is needed, or None")
    patches = _patches(spline, x, y, dx, dy)
    corners = [patch.corners() for patch in patches]
    inner = max(c.upper for c in corners) - min(c.lower for c in corners)
    allowance = tolerance * inner
    lower = _refined_lower(patches, allowance)
    upper = -_refined_lower([_negated(patch) for patch in patches], allowance)
    return Interval(lower, upper)


def exact_value(
    spline: ExactSpline, x: Fraction, y: Fraction, dx: int = 0, dy: int = 0
) -> Fraction:
    """Return the value of a partial derivative at one point, exactly."""
    point = exact_bounds(spline, Interval(x, x), Interval(y, y), dx, dy)
    return point.lower


def _hulls(spline: ExactSpline, x: Interval, y: Interval, dx: int, dy: int) -> list[Interval]:
    """Return the hull of each patch; those of whole cells are made once."""
    columns = pieces(spline.y, y, dy)
    found = []
    for x_span, x_map in pieces(spline.x, x, dx):
        whole_x = x_map is spline.x.maps[x_span, dx]
        for y_span, y_map in columns:
            key = (x_span, y_span, dx, dy)
            if not whole_x or y_map is not spline.y.maps[y_span, dy]:
                found.append(_patch(spline, x_span, x_map, y_span, y_map).hull())
                continue
            if key not in spline.hulls:
                spline.hulls[key] = _patch(spline, x_span, x_map, y_span, y_map).hull()
            found.append(spline.hulls[key])
    return found


def _patches(spline: ExactSpline, x: Interval, y: Interval, dx: int, dy: int) -> list[Patch]:
    """Return the restriction to the rectangle, one patch per cell that it meets."""
    return [
        _patch(spline, x_span, x_map, y_span, y_map)
        for x_span, x_map in pieces(spline.x, x, dx)
        for y_span, y_map in pieces(spline.y, y, dy)
    ]


def _patch(spline: ExactSpline, x_span: int, x_map: AxisMap, y_span: int, y_map: AxisMap) -> Patch:
    """Return the Bernstein coefficients b = X C Y' of one cell, or of the mapped part of it."""
    local = [
        row[y_span - DEGREE : y_span + 1]
        for row in spline.coefficients[x_span - DEGREE : x_span + 1]
    ]
    rows = times_columns(times(x_map.rows, tuple(local)), y_map.rows)
    return Patch(rows, x_map.denominator * y_map.denominator * spline.scale)


def _refined_lower(patches: list[Patch], allowance: Fraction) -> Fraction:
    """Return a lower bound within ``allowance`` of the minimum, by best-first bisection."""
    best = min(patch.corners().lower for patch in patches)
    order = count()
    heap = [(patch.hull().lower, next(order), patch) for patch in patches]
    heapq.heapify(heap)
    for _ in range(MAX_SPLITS):
        if best - heap[0][0] <= allowance:
            break
        _, _, patch = heapq.heappop(heap)
        for half in _halves(patch):
            best = min(best, half.corners().lower)
            heapq.heappush(heap, (half.hull().lower, next(order), half))
    return heap[0][0]


def _halves(patch: Patch) -> tuple[Patch, Patch]:
    """Split at the middle of the direction in which the coefficients change more."""
    along_x = _largest_step(tuple(zip(*patch.rows, strict=True)))
    along_y = _largest_step(patch.rows)
    if along_y >= along_x:
        return _halves_along_y(patch)
    turned = Patch(tuple(zip(*patch.rows, strict=True)), patch.denominator)
    first, second = (
        Patch(tuple(zip(*half.rows, strict=True)), half.denominator)
        for half in _halves_along_y(turned)
    )
    return first, second


def _largest_step(rows: Rows) -> int:
    return max((abs(b - a) for row in rows for a, b in zip(row, row[1:], strict=False)), default=0)


def _halves_along_y(patch: Patch) -> tuple[Patch, Patch]:
    """de Casteljau at 1/2, with the factor 2**degree moved into the denominator."""
    degree = len(patch.rows[0]) - 1
    left_rows, right_rows = [], []
    for row in patch.rows:
        current, left, right = list(row), [], []
        for level in range(degree + 1):
            left.append(current[0] << (degree - level))
            right.append(current[-1] << (degree - level))
            current = [a + b for a, b in zip(current, current[1:], strict=False)]
        left_rows.append(tuple(left))
        right_rows.append(tuple(reversed(right)))
    unit = patch.denominator << degree
    return Patch(tuple(left_rows), unit), Patch(tuple(right_rows), unit)


def _negated(patch: Patch) -> Patch:
    return Patch(tuple(tuple(-entry for entry in row) for row in patch.rows), patch.denominator)
