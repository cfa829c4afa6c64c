"""Increasing functions of intervals, made of their values at points; pi and the padding of series.

A function is worked out at points, on a grid of 10^48 with series whose rounding and remainder are
both far below the padding; the result is rounded outward to the grid of 10^36.
"""

from __future__ import annotations

from collections.abc import Callable

from takagi.certificates.checker.arithmetic.exponential import FINE
from takagi.certificates.checker.arithmetic.interval import ONE, Interval

GUARD = FINE // ONE
# Units of FINE.  A series here has at most 60 terms, each of which errs by at most two units for
# every earlier one, and is multiplied by at most 8 afterwards: 60 * 60 * 2 * 8 < 10^5.
PAD = 10**5
PI_FINE = 3141592653589793238462643383279502884197169399375  # pi 10^48, rounded down
Point = Callable[[int], tuple[int, int]]


def pi_interval() -> Interval:
    return Interval(PI_FINE // GUARD, PI_FINE // GUARD + 1)


def increasing(at: Point, at_zero: int | None = 0) -> Callable[[Interval], Interval]:
    """Return the function of intervals, from ``at``: x FINE -> a bracket of f(x) FINE.

    Parameters
    ----------
    at_zero : f(0) ONE, which is exact; None where 0 is nothing special.
    """

    def of(a: Interval) -> Interval:
        low, high = at(a[0] * GUARD)[0] // GUARD, -(-at(a[1] * GUARD)[1] // GUARD)
        if at_zero is None:
            return Interval(low, high)
        return Interval(at_zero if a.low == 0 else low, at_zero if a.high == 0 else high)

    return of
