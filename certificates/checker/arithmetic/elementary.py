"""Elementary functions of intervals: sin, cos, tan, atan, asin, acos; all others by name.

Increasing functions take their ends to ends (``monotone``); sin and cos look for the extremes
between.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import isqrt

from takagi.certificates.checker.arithmetic.exponential import FINE, exp_at
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.arithmetic.logarithm import (
    acosh_at,
    asinh_at,
    atanh_at,
    error_function,
    hyperbolic_cosine,
    hyperbolic_tangent,
    log_at,
    sinh_at,
)
from takagi.certificates.checker.arithmetic.monotone import GUARD, PAD, PI_FINE, increasing
from takagi.certificates.checker.kernel.refusal import Refused

FARTHEST = 10**6  # of an angle, in rad: pi is known to 10^-48


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
        # Rounding toward 0 makes the terms reach 0, so the loop ends.
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
    quarter_turn = (turns + quarter) % 4
    value = _series(r, 1 - quarter_turn % 2)
    return _padded(-value if quarter_turn >= 2 else value, PAD + 2 * FARTHEST)


def _sine(a: Interval, quarter: int) -> Interval:
    """Return sin(a + quarter pi/2); extremes between the ends are included."""
    if a == (0, 0):
        return Interval(quarter * ONE, quarter * ONE)
    low, high = a[0] * GUARD, a[1] * GUARD
    ends = [_sine_at(low, quarter), _sine_at(high, quarter)]
    lower = min(end[0] for end in ends) // GUARD
    upper = -(-max(end[1] for end in ends) // GUARD)
    # The extreme +1 lies at pi/2 (4 k + 1 - quarter), -1 at pi/2 (4 k + 3 - quarter).
    if _meets(low, high, 1 - quarter):
        upper = ONE
    if _meets(low, high, 3 - quarter):
        lower = -ONE
    return Interval(max(lower, -ONE), min(upper, ONE))


def _meets(low: int, high: int, quarters: int) -> bool:
    """Return whether some pi/2 (4 k + quarters) may lie in [low, high]."""
    slack = 4 * FARTHEST + 8
    first = low - slack - quarters * PI_FINE // 2
    k = -(-first // (2 * PI_FINE))
    return k * 2 * PI_FINE + quarters * PI_FINE // 2 <= high + slack


def sine(a: Interval) -> Interval:
    return _sine(a, 0)


def cosine(a: Interval) -> Interval:
    return _sine(a, 1)


def tangent(a: Interval) -> Interval:
    """Return tan, which increases where cos has no zero."""
    # On less than half a turn tan is increasing unless cos vanishes in between, which is tested
    # next.
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
        # For x > 1 the series converges too slowly: atan x = pi/2 - atan(1/x).
        return PI_FINE // 2 - high - 2, PI_FINE // 2 - low + 2
    # Two halvings of the angle make x small, so that the series needs few terms.
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
    enclosures: dict[str, Callable[[Interval], Interval]] = {
        "sin": sine,
        "cos": cosine,
        "tan": tangent,
        "atan": increasing(_atan_at),
        "asin": increasing(_asin_at),
        "acos": _acos,
        "abs": _absolute,
        "exp": increasing(exp_at, ONE),
        "log": increasing(log_at, None),
        "sinh": increasing(sinh_at),
        "cosh": hyperbolic_cosine,
        "tanh": hyperbolic_tangent,
        "asinh": increasing(asinh_at),
        "acosh": increasing(acosh_at, None),
        "atanh": increasing(atanh_at),
        "erf": error_function,
    }
    if name not in enclosures:
        raise Refused(f"no enclosure of {name}")
    return enclosures[name]
