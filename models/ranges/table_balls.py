"""Tables (splines) evaluated in balls: from balls to exact intervals, Bernstein hulls, and back."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from takagi.models.intervals.interval import Interval

Ball: TypeAlias = Any  # flint.arb carries no type annotations
# Rounding may move an argument outside its table by this share of the table's width.
EDGE = Fraction(1, 2**90)
WIDE = 30  # bits that a ball's width may be smaller than its number to be called wide


def tables_class() -> type[Any] | None:
    """Return ``TableFunction`` if it is loaded; otherwise no expression can contain one."""
    module = sys.modules.get("takagi.models.splines.table_function")
    return None if module is None else module.TableFunction


class TableBalls:
    """A table as an operation on balls.

    Beyond its edge by ``EDGE`` a table is held at its edge.  An argument that leaves it by more
    gives no bound, unless it was proved that all arguments are inside: then the part of the ball
    that is outside is only overestimation, and is cut off.
    """

    def __init__(self, function: Any) -> None:
        from takagi.models.splines.table_function import table_ranges

        self.bounds = function.bounds
        self.orders = function.orders
        self.ranges = table_ranges(function.table)

    def __call__(self, balls: Sequence[Ball], covered: bool) -> Ball:
        from flint import arb

        sides, left = [], False
        for ball, covers in zip(balls, self.ranges, strict=True):
            if not ball.is_finite():
                return arb.nan()
            low, high = _ends(ball)
            over = max(covers.lower - low, high - covers.upper)
            if over > 0:
                apart = low > covers.upper or high < covers.lower
                if over > EDGE * covers.width and (apart or not covered):
                    return arb.nan()
                left = left or not covered
                low = min(max(low, covers.lower), covers.upper)
                high = max(min(high, covers.upper), covers.lower)
            sides.append(Interval(low, high))
        found = self.bounds(*sides)
        if left and any(self.orders):
            found = found.hull(0)  # the slope of a function that is held at its edge
        return ball_of(found)


def _ends(ball: Ball) -> tuple[Fraction, Fraction]:
    """Return ends around a ball: exact for a narrow one, short numbers for a wide one.

    Exact arithmetic with ends of 128 bits costs several times that with floats.
    """
    low, high = ball.lower(), ball.upper()
    if (high - low) * 2**WIDE > abs(ball):
        first, last = math.nextafter(float(low), -math.inf), math.nextafter(float(high), math.inf)
        return Fraction(first), Fraction(last)
    return fraction_of(low), fraction_of(high)


def ball_of(interval: Interval) -> Ball:
    """Return a ball that contains the interval."""
    from flint import arb, fmpq

    lower, upper = (arb(fmpq(e.numerator, e.denominator)) for e in (interval.lower, interval.upper))
    return lower if interval.lower == interval.upper else lower.union(upper)


def fraction_of(point: Ball) -> Fraction:
    """Return an exact ball (of radius 0) as a rational."""
    mantissa, exponent = point.man_exp()
    m, e = int(mantissa), int(exponent)
    return Fraction(m << e) if e >= 0 else Fraction(m, 1 << -e)
