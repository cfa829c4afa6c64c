"""A table's spline as the two polynomials that it is beside a point.

A cubic spline has two continuous derivatives; its third jumps at knots.  Where a premise such as
friction(omega)/omega is 0/0, the spline is one cubic below the point and one above it, so the
premise is one quadratic on each side.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.splines.curve import Curve

DEGREE = 3


def beside(
    expression: sp.Expr, symbol: sp.Symbol, place: sp.Expr
) -> tuple[sp.Expr, sp.Expr, float] | None:
    """Return the expression below and above ``symbol = place``, and how far from there they hold.

    None for an expression without tables.

    Raises
    ------
    ModelError : a table of two arguments, one of another argument than symbol plus a number, or a
        place that is no rational number.
    """
    import sympy as sp

    from takagi.models.splines.curve import Curve
    from takagi.models.splines.table_function import TableFunction

    calls = sorted(expression.atoms(TableFunction), key=str)
    if not calls:
        return None
    below: dict[sp.Expr, sp.Expr] = {}
    above: dict[sp.Expr, sp.Expr] = {}
    reach = float("inf")
    for call in calls:
        if symbol not in call.free_symbols:
            continue
        (argument, *others) = call.args
        curve = call.func.table
        if others or not isinstance(curve, Curve) or not (argument - symbol).is_Rational:
            raise ModelError(f"{call} is no table of {symbol} alone, plus a number")
        at = argument.subs(symbol, place)
        if not at.is_Rational:
            raise ModelError(f"{call} is 0/0 where {symbol} is {place}, which is no number")
        x = Fraction(int(at.p), int(at.q))
        (order,) = call.func.orders
        for found, side in ((below, -1), (above, 1)):
            powers = _piece(curve, x, side)
            t = argument - at
            cubic = sum(sp.Rational(*c.as_integer_ratio()) * t**k for k, c in enumerate(powers))
            found[call] = sp.diff(cubic, symbol, order)
        reach = min(reach, _reach(curve, x))
    return expression.xreplace(below), expression.xreplace(above), reach


def _piece(curve: Curve, x: Fraction, side: int) -> list[Fraction]:
    """Return the Taylor coefficients at x of the polynomial below (-1) or above (1) it."""
    knots = [Fraction(repr(float(k))) for k in curve.knots]
    coefficients = [Fraction(repr(float(c))) for c in curve.coefficients]
    spans = [k for k in range(DEGREE, len(knots) - DEGREE - 1) if knots[k] < knots[k + 1]]
    inside = [
        k
        for k in spans
        if (knots[k] < x <= knots[k + 1] if side < 0 else knots[k] <= x < knots[k + 1])
    ]
    span = inside[0] if inside else (spans[0] if side < 0 else spans[-1])
    # The cubic through four values, by Newton's divided differences about x.
    points = [x + Fraction(k) * (knots[span + 1] - knots[span]) / 3 for k in range(DEGREE + 1)]
    table = [_de_boor(knots, coefficients, span, point) for point in points]
    for level in range(1, DEGREE + 1):
        for k in range(DEGREE, level - 1, -1):
            table[k] = (table[k] - table[k - 1]) / (points[k] - points[k - level])
    found = [Fraction(0)] * (DEGREE + 1)
    for value, point in zip(table[::-1], points[::-1], strict=True):
        shifted = [Fraction(0), *found[:-1]]
        offset = point - x
        found = [a - offset * b for a, b in zip(shifted, found, strict=True)]
        found[0] += value
    return found


def _de_boor(
    knots: list[Fraction], coefficients: list[Fraction], span: int, x: Fraction
) -> Fraction:
    """Return the value at x of the polynomial that the spline is on one span."""
    d = coefficients[span - DEGREE : span + 1]
    for r in range(1, DEGREE + 1):
        for j in range(DEGREE, r - 1, -1):
            low = knots[j + span - DEGREE]
            share = (x - low) / (knots[j + 1 + span - r] - low)
            d[j] = (1 - share) * d[j - 1] + share * d[j]
    return d[DEGREE]


def _reach(curve: Curve, x: Fraction) -> float:
    """Return the distance from x to the nearest other knot."""
    away = {abs(Fraction(repr(float(k))) - x) for k in curve.knots} - {Fraction(0)}
    return float(min(away))
