"""Elementary functions of intervals: sin, cos, tan, atan, asin, acos, and by name all others.

A function is worked out at points, on a grid of 10^48 with series whose rounding and remainder are
both far below the padding; the result is rounded outward to the grid of 10^36.  Increasing
functions take their ends to ends; sin and cos look for the extremes between.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import isqrt

from takagi.certificates.checker.arithmetic.exponential import FINE, exp_at
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["GUARD", "PAD", "PI_FINE", "function_of", "increasing", "pi_interval"]

GUARD = FINE // ONE
# Units of FINE.  A series here has at most 60 terms, each of which errs by at most two units for
# every earlier one, and is multiplied by at most 8 afterwards: 60 * 60 * 2 * 8 < 10^5.
PAD = 10**5
PI_FINE = 3141592653589793238462643383279502884197169399375  # pi 10^48, rounded down
FARTHEST = 10**6  # of an angle, in rad: pi is known to 10^-48
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


def _padded(value: int, pad: int = PAD) -> tuple[int, int]:
    return value - pad, value + pad


# ---------------------------------------------------------------------- sin and cos


def _series(r: int, first: int) -> int:
    """Return sum_k (-1)^k r^(2k + first) / (2k + first)! for |r| <= 1, to within PAD."""
    square = r * r // FINE
    term = r if first else FINE
    total, n = 0, first
    while term:
        total += term
        # Toward 0, so that the terms end.
        product = abs(term) * square // (FINE * (n + 1) * (n + 2))
        term = -product if term > 0 else product
        n += 2
    return total


def _sine_at(x: int, quarter: int) -> tuple[int, int]:
    """Return a bracket of sin(x + quarter pi/2)."""
    if abs(x) > FARTHEST * FINE:
        raise Refused(f"an angle beyond {FARTHEST} rad")
    turns = (2 * x + PI_FINE // 2) // PI_FINE
    # x - turns pi/2 within [-pi/4, pi/4]; pi errs by one unit, turns by at most FARTHEST.
    r = x - turns * PI_FINE // 2
    place = (turns + quarter) % 4
    value = _series(r, 1 - place % 2)
    return _padded(-value if place >= 2 else value, PAD + 2 * FARTHEST)


def _sine(a: Interval, quarter: int) -> Interval:
    """Return sin(a + quarter pi/2); both extremes are looked for between the ends."""
    if a == (0, 0):
        return Interval(quarter * ONE, quarter * ONE)
    low, high = a[0] * GUARD, a[1] * GUARD
    ends = [_sine_at(low, quarter), _sine_at(high, quarter)]
    least = min(end[0] for end in ends) // GUARD
    most = -(-max(end[1] for end in ends) // GUARD)
    # The extreme +1 lies at pi/2 (4 k + 1 - quarter), -1 at pi/2 (4 k + 3 - quarter).
    if _meets(low, high, 1 - quarter):
        most = ONE
    if _meets(low, high, 3 - quarter):
        least = -ONE
    return Interval(max(least, -ONE), min(most, ONE))


def _meets(low: int, high: int, place: int) -> bool:
    """Return whether some pi/2 (4 k + place) may lie in [low, high]."""
    slack = 4 * FARTHEST + 8
    first = low - slack - place * PI_FINE // 2
    k = -(-first // (2 * PI_FINE))
    return k * 2 * PI_FINE + place * PI_FINE // 2 <= high + slack


def sine(a: Interval) -> Interval:
    return _sine(a, 0)


def cosine(a: Interval) -> Interval:
    return _sine(a, 1)


def tangent(a: Interval) -> Interval:
    """Return tan, which increases where cos has no zero."""
    if a[1] - a[0] >= 3 * ONE:
        raise Refused("tan over more than half a turn")
    middle = cosine(a)
    if middle[0] <= 0 <= middle[1]:
        raise Refused("tan where cos may be zero")
    first, last = (sine(end) / cosine(end) for end in (Interval(x, x) for x in a))
    return Interval(first.low, last.high)


# ---------------------------------------------------------------------- atan, asin, acos


def _atan_at(x: int) -> tuple[int, int]:
    if x < 0:
        low, high = _atan_at(-x)
        return -high, -low
    if x > FINE:
        low, high = _atan_at(FINE * FINE // x)
        return PI_FINE // 2 - high - 2, PI_FINE // 2 - low + 2
    for _ in range(2):
        x = x * FINE // (FINE + isqrt(FINE * FINE + x * x))  # tan of half the angle
    square, power, total, n = x * x // FINE, x, 0, 1
    while power:
        total += power // n if n % 4 == 1 else -(power // n)
        power = power * square // FINE
        n += 2
    return _padded(4 * total)


def _asin_at(x: int) -> tuple[int, int]:
    """Return a bracket of asin x = 2 atan(x / (1 + sqrt(1 - x^2)))."""
    if abs(x) > FINE:
        raise Refused("asin or acos beyond 1")
    # x is exact here, so that the root errs by one unit alone, also near 1.
    low, high = _atan_at(x * FINE // (FINE + isqrt(FINE * FINE - x * x)))
    return 2 * low - PAD, 2 * high + PAD


def _acos(a: Interval) -> Interval:
    low, high = increasing(_asin_at)(a)
    half = PI_FINE // 2 // GUARD
    return Interval(half - high - 1, half - low + 2)


def _absolute(a: Interval) -> Interval:
    return Interval(a.least(), a.magnitude())


@cache
def function_of(name: str) -> Callable[[Interval], Interval]:
    """Return the function of intervals of that name.

    Raises
    ------
    Refused : an unknown name; and, when called, an argument outside the function's domain.
    """
    # Imported here: these functions are made of the ones above.
    from takagi.certificates.checker.arithmetic import logarithm as e

    known: dict[str, Callable[[Interval], Interval]] = {
        "sin": sine,
        "cos": cosine,
        "tan": tangent,
        "atan": increasing(_atan_at),
        "asin": increasing(_asin_at),
        "acos": _acos,
        "abs": _absolute,
        "exp": increasing(exp_at, ONE),
        "log": increasing(e.log_at, None),
        "sinh": increasing(e.sinh_at),
        "cosh": e.hyperbolic_cosine,
        "tanh": e.hyperbolic_tangent,
        "asinh": increasing(e.asinh_at),
        "acosh": increasing(e.acosh_at, None),
        "atanh": increasing(e.atanh_at),
        "erf": e.error_function,
    }
    if name not in known:
        raise Refused(f"no enclosure of {name}")
    return known[name]
