r"""Ranges of polynomials and rational functions of several variables in Bernstein form, exactly.

On a box, p(x) = \sum_i b_i B_i(x) with B_i >= 0 and \sum_i B_i = 1, so that
min b_i <= p <= max b_i.  The coefficients at the corners are values of p.  For
N/D of equal degree with all d_i of one sign,

    N/D = \sum_i (n_i / d_i) w_i,    w_i = d_i B_i / D >= 0,  \sum_i w_i = 1,

so that min n_i/d_i <= N/D <= max n_i/d_i.  Coefficients are integers over one denominator; halving
a box is de Casteljau's recursion at 1/2.  Nothing is rounded.

Source: Garloff (1986), "Convergent bounds for the range of multivariate polynomials"; Narkawicz,
Garloff, Smith, Munoz (2012), "Bounding the range of a rational function over a box", Reliable
Computing 17.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import comb, lcm, prod
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from takagi.models.intervals.box_search import Bounded
from takagi.models.intervals.interval import Interval

Integers: TypeAlias = NDArray[Any]  # of Python integers: dtype object
MOST_COEFFICIENTS = 400  # with more coefficients ball arithmetic is faster
MOST_OPERATIONS = 300  # sympy rewrites no longer expression as one fraction; that would be slow


class PolynomialBox(NamedTuple):
    """N/D on a box: Bernstein coefficients up to one common factor, ``scale`` = n-unit / d-unit.

    Attributes
    ----------
    sides : of the box.
    above : integers, one axis for each variable.
    below : likewise, of D; None when D = 1.
    scale : N/D = scale * (sum of above) / (sum of below).
    """

    sides: tuple[Interval, ...]
    above: Integers
    below: Integers | None
    scale: Fraction


def polynomial_box(
    expression: sp.Expr, symbols: Sequence[sp.Symbol], sides: Sequence[Interval]
) -> PolynomialBox | None:
    """Return the expression on the box; None when it is not a quotient of polynomials, or large."""
    from sympy.polys.polyerrors import BasePolynomialError

    if not symbols or not expression.is_rational_function(*symbols):
        return None
    if expression.count_ops() > MOST_OPERATIONS:
        return None
    try:
        # Without common factor; this also removes removable singularities.
        pair = (
            (expression, sp.S.One)
            if expression.is_polynomial()
            else sp.fraction(sp.cancel(expression))
        )
        fraction = [sp.Poly(polynomial, *symbols, domain="QQ") for polynomial in pair]
    except BasePolynomialError:
        return None  # coefficients such as pi or 1/(2 + sin(1))^9 are not rational
    above, below = (dict(polynomial.terms()) for polynomial in fraction)
    degrees = [max(m[k] for m in (*above, *below)) for k in range(len(symbols))]
    if prod(degree + 1 for degree in degrees) > MOST_COEFFICIENTS:
        return None
    n, n_unit = _bernstein(above, degrees, sides)
    if fraction[1].is_one:
        return PolynomialBox(tuple(sides), n, None, Fraction(1, n_unit))
    d, d_unit = _bernstein(below, degrees, sides)
    return PolynomialBox(tuple(sides), n, d, Fraction(d_unit, n_unit))


def look_at_polynomial(box: PolynomialBox) -> Bounded:
    """Return enclosure and attained corner values over the box; see ``search``."""
    axis = _axis(box)
    below = [1] * box.above.size if box.below is None else box.below.ravel().tolist()
    if not (min(below) > 0 or max(below) < 0):
        return Bounded(None, None, axis)
    above = box.above.ravel().tolist()
    if box.below is None:
        low, high = Fraction(min(above)), Fraction(max(above))
    else:
        shares = [Fraction(n, d) for n, d in zip(above, below, strict=True)]
        low, high = min(shares), max(shares)
    index = np.ix_(*([0, -1] for _ in box.sides))
    corners = box.above[index].ravel().tolist()
    under = [1] * len(corners) if box.below is None else box.below[index].ravel().tolist()
    values = [Fraction(n, d) for n, d in zip(corners, under, strict=True)]
    scale = box.scale
    return Bounded((low * scale, high * scale), (min(values) * scale, max(values) * scale), axis)


def has_pole(box: PolynomialBox) -> bool:
    """Return whether D vanishes at a corner of the box or changes its sign between corners.

    N and D have no common factor, so N cannot vanish wherever D does.
    """
    if box.below is None:
        return False
    corners = box.below[np.ix_(*([0, -1] for _ in box.sides))].ravel().tolist()
    return bool(min(corners) <= 0 <= max(corners))


def halved_polynomial(box: PolynomialBox, axis: int) -> tuple[PolynomialBox, PolynomialBox]:
    """Return both halves of the box along one side; the common factor 2^degree is dropped."""
    side = box.sides[axis]
    half_sides = Interval(side.lower, side.centre), Interval(side.centre, side.upper)
    above = _casteljau(box.above, axis)
    below = (None, None) if box.below is None else _casteljau(box.below, axis)
    degree = box.above.shape[axis] - 1
    # N and D of one quotient lose the same factor; a polynomial alone keeps it in its scale.
    scale = box.scale / 2**degree if box.below is None else box.scale
    first, second = (
        PolynomialBox((*box.sides[:axis], half_side, *box.sides[axis + 1 :]), n, d, scale)
        for half_side, n, d in zip(half_sides, above, below, strict=True)
    )
    return first, second


def _bernstein(
    terms: Mapping[tuple[int, ...], sp.Rational], degrees: Sequence[int], sides: Sequence[Interval]
) -> tuple[Integers, int]:
    """Return Bernstein coefficients times a unit, and the unit."""
    values: NDArray[Any] = np.full([degree + 1 for degree in degrees], Fraction(0), dtype=object)
    for powers, coefficient in terms.items():
        values[powers] = Fraction(int(coefficient.p), int(coefficient.q))
    for axis, (degree, side) in enumerate(zip(degrees, sides, strict=True)):
        turned = np.moveaxis(values, axis, 0)
        mixed = np.dot(_to_bernstein(degree, side), turned.reshape(degree + 1, -1))
        values = np.moveaxis(mixed.reshape(turned.shape), 0, axis)
    unit = lcm(*(value.denominator for value in values.ravel()))
    integers: NDArray[Any] = np.empty(values.shape, dtype=object)
    integers.ravel()[:] = [int(value * unit) for value in np.ascontiguousarray(values).ravel()]
    return integers, unit


def _to_bernstein(degree: int, side: Interval) -> NDArray[Any]:
    """Return M with b = M a for sum_k a_k x^k on the side.

    Column k is the blossom of x^k, sum_j C(i, j) C(n - i, k - j) u^j l^(k - j) / C(n, k) at i
    times the upper end u and n - i times the lower end l.
    """
    n, low, high = degree, side.lower, side.upper
    matrix: NDArray[Any] = np.empty((n + 1, n + 1), dtype=object)
    for i in range(n + 1):
        for k in range(n + 1):
            total = sum(
                (
                    comb(i, j) * comb(n - i, k - j) * high**j * low ** (k - j)
                    for j in range(max(0, k - (n - i)), min(i, k) + 1)
                ),
                Fraction(0),
            )
            matrix[i, k] = total / comb(n, k)
    return matrix


def _casteljau(values: Integers, axis: int) -> tuple[Integers, Integers]:
    """Return the coefficients of both halves, times 2^degree."""
    current = np.moveaxis(values, axis, 0)
    degree = len(current) - 1
    lower, upper = np.empty_like(current), np.empty_like(current)
    for level in range(degree + 1):
        lower[level] = current[0] * (1 << (degree - level))
        upper[degree - level] = current[-1] * (1 << (degree - level))
        current = current[:-1] + current[1:]
    return np.moveaxis(lower, 0, axis), np.moveaxis(upper, 0, axis)


def _axis(box: PolynomialBox) -> int | None:
    """Return the side along which neighbouring coefficients differ most; None for a point."""
    best, axis = -1, None
    for k, side in enumerate(box.sides):
        if side.width == 0:
            continue
        change = -1
        for values in (box.above, box.below):
            if values is not None and values.shape[k] > 1:
                steps = np.abs(np.diff(values, axis=k)).max()
                change = max(change, int(steps))
        if change > best or axis is None:
            best, axis = change, k
    return axis
