r"""Exact values and rigorous ranges of a bicubic spline given by decimals.

On one cell of the knot grid a bicubic spline, and each partial derivative of it, is a polynomial.
Written in Bernstein form on a rectangle,

    p(s, t) = \sum_{ij} b_ij B_i(s) B_j(t),     B_i >= 0,  \sum_i B_i = 1,

so min b_ij <= p <= max b_ij there, and the corner coefficients are values of p.  The map from the
B-spline coefficients C of a cell to the b_ij of a derivative on a sub-rectangle is linear in each
direction, b = X C Y', with rational X and Y: the four basis functions of a span are polynomials,
and the coefficients a_k of z^k on [0, 1] give the Bernstein ones, b_i = sum_k C(i, k) / C(n, k)
a_k.  X and Y are kept as integers over one denominator and C as integers over a power of ten, so
every number here is exact: there is no rounding to bound, and the range over a box is the union of
the ranges over the cells that the box meets.

Source: Lane and Riesenfeld (1981), "Bounds on a polynomial", BIT 21 (range from Bernstein
coefficients); de Boor (1978), A Practical Guide to Splines, ch. X (the basis functions).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field
from fractions import Fraction
from math import comb
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly, fmpz_mat
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Polynomials: TypeAlias = tuple[Any, ...]  # flint carries no type annotations
DEGREE = 3
MAX_ORDER = 2  # second derivatives are the last continuous ones
# From coefficients of powers on [0, 1] to those of Bernstein's polynomials, by the degree.
BERNSTEIN = [
    fmpq_mat(
        n + 1, n + 1, [fmpq(comb(i, k), comb(n, k)) for i in range(n + 1) for k in range(n + 1)]
    )
    for n in range(DEGREE + 1)
]


# A point given in other units lands on the edge only up to rounding: 30 deg is 3e-13 rad
# outside a knot of 12 decimals.  Points that far outside are moved to the edge; points further
# outside are refused.
EDGE = 1e-9


@dataclass(frozen=True, slots=True)
class AxisMap:
    """Integer matrix over one denominator: four B-spline coefficients to Bernstein coefficients."""

    rows: Any
    denominator: int


@dataclass(frozen=True, slots=True)
class KnotAxis:
    """Knots of one direction with, per non-empty span and order, basis and map of the whole span.

    ``basis`` : the four functions that are not 0 on the span, and their derivatives by x, as
    polynomials in the share of the span.
    """

    knots: tuple[Fraction, ...]
    spans: tuple[int, ...]
    starts: tuple[Fraction, ...]  # where each span begins
    basis: dict[tuple[int, int], Polynomials]
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
            span_map, width = axis.maps[span, order], end - start
            if low != start or high != end:
                shares = (low - start) / width, (high - start) / width
                span_map = _map(axis.basis[span, order], DEGREE - order, *shares)
            maps.append((span, span_map))
            if where.width == 0:
                break  # both neighbours of a knot agree there: orders up to 2 are continuous
    return maps


def _map(basis: Polynomials, degree: int, s: Fraction, t: Fraction) -> AxisMap:
    """Return the map for the part [s, t] of a span, 0 <= s <= t <= 1."""
    line = fmpq_poly([_rational(s), _rational(t - s)])
    moved = [polynomial(line) for polynomial in basis]
    powers = [polynomial[k] for k in range(degree + 1) for polynomial in moved]
    rows, unit = (BERNSTEIN[degree] * fmpq_mat(degree + 1, DEGREE + 1, powers)).numer_denom()
    return AxisMap(rows, int(unit))


def _rational(number: Fraction) -> Any:
    return fmpq(number.numerator, number.denominator)


def axis_of(knots: tuple[Fraction, ...]) -> KnotAxis:
    """Return the axis with those full knots, its whole-span maps computed."""
    spans = tuple(i for i in range(DEGREE, len(knots) - DEGREE - 1) if knots[i] < knots[i + 1])
    basis: dict[tuple[int, int], Polynomials] = {}
    for span in spans:
        width = _rational(knots[span + 1] - knots[span])
        functions = _basis([_rational(knot) for knot in knots], span)
        for order in range(MAX_ORDER + 1):
            basis[span, order] = functions
            functions = tuple(polynomial.derivative() / width for polynomial in functions)
    unit_interval = Fraction(0), Fraction(1)
    maps = {
        (span, order): _map(B, DEGREE - order, *unit_interval) for (span, order), B in basis.items()
    }
    return KnotAxis(knots, spans, tuple(knots[span] for span in spans), basis, maps)


def _basis(knots: list[Any], span: int) -> Polynomials:
    """Return the four B-splines that are not 0 on a span, by de Boor's recursion."""
    x = fmpq_poly([knots[span], knots[span + 1] - knots[span]])
    N = {span: fmpq_poly([1])}
    for q in range(1, DEGREE + 1):
        higher = {}
        for j in range(span - q, span + 1):
            higher[j] = fmpq_poly([0])
            if j in N:
                higher[j] += N[j] * (x - knots[j]) / (knots[j + q] - knots[j])
            if j + 1 in N:
                end = knots[j + q + 1]
                higher[j] += N[j + 1] * (end - x) / (end - knots[j + 1])
        N = higher
    return tuple(N[span - DEGREE + k] for k in range(DEGREE + 1))


@dataclass(frozen=True, slots=True)
class ExactSpline:
    """A bicubic spline in exact numbers: two axes, and coefficients / scale as integers."""

    x: KnotAxis
    y: KnotAxis
    coefficients: tuple[tuple[int, ...], ...]
    scale: int
    # Hulls of whole cells: (span in x, span in y, order in x, order in y) -> hull.
    hulls: dict[tuple[int, int, int, int], Interval] = field(
        default_factory=dict, repr=False, compare=False
    )


def exact_spline(
    x_knots: tuple[Fraction, ...],
    y_knots: tuple[Fraction, ...],
    coefficients: tuple[tuple[int, ...], ...],
    scale: int,
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
    rows = spline.coefficients[x_span - DEGREE : x_span + 1]
    local = [entry for row in rows for entry in row[y_span - DEGREE : y_span + 1]]
    C = fmpz_mat(DEGREE + 1, DEGREE + 1, local)
    values = (x_map.rows * C * y_map.rows.transpose()).entries()
    unit = x_map.denominator * y_map.denominator * spline.scale
    return Interval(Fraction(int(min(values)), unit), Fraction(int(max(values)), unit))


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
