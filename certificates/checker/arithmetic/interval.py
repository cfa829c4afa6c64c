"""Intervals: pairs of integers that bracket a number times 10^36, rounded outward.

Every operation rounds its lower end down and its upper end up, so the exact result lies inside.
Integers, not Fractions: no greatest common divisors and constant size.  A decimal grid, so that the
ends of a box and products of them are exact: a bound that is attained, such as x^2 <= 0.01 on
|x| <= 0.1, can be proved.

``add`` and ``product`` round nothing, and take ends that are fractions as well.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias, TypeVar

from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["ONE", "ZERO", "Ends", "Interval", "add", "div", "enclose", "held", "hull", "magnitude"]
__all__ += ["mul", "neg", "point", "product", "square", "sub", "within"]

ONE = 10**36
LARGEST = ONE * 10**320
Interval: TypeAlias = tuple[int, int]
# The same with rational ends, which are not rounded.
Ends: TypeAlias = tuple[Fraction, Fraction]
Exact = TypeVar("Exact", int, Fraction)
ZERO: Interval = (0, 0)


def enclose(low: Fraction, high: Fraction) -> Interval:
    """Return the bracket of [low, high]."""
    down = low.numerator * ONE // low.denominator
    return down, -(-high.numerator * ONE // high.denominator)


def point(value: Fraction) -> Interval:
    """Return the bracket of one number."""
    return enclose(value, value)


def hull(*parts: Interval) -> Interval:
    """Return the smallest bracket of all parts."""
    return min(p[0] for p in parts), max(p[1] for p in parts)


def add(a: tuple[Exact, Exact], b: tuple[Exact, Exact]) -> tuple[Exact, Exact]:
    return a[0] + b[0], a[1] + b[1]


def sub(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def neg(a: Interval) -> Interval:
    return -a[1], -a[0]


def product(a: tuple[Exact, Exact], b: tuple[Exact, Exact]) -> tuple[Exact, Exact]:
    """Return the range of x y, over 10^72 where the ends are over 10^36."""
    if a[0] >= 0 and b[0] >= 0:
        return a[0] * b[0], a[1] * b[1]
    corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return min(corners), max(corners)


def mul(a: Interval, b: Interval) -> Interval:
    """Return a bracket of the product."""
    low, high = product(a, b)
    return held((low // ONE, -(-high // ONE)))


def square(a: Interval) -> Interval:
    """Return a bracket of x^2, which is not negative."""
    low, high = sorted((abs(a[0]), abs(a[1])))
    least = 0 if a[0] <= 0 <= a[1] else low * low // ONE
    return held((least, -(-high * high // ONE)))


def div(a: Interval, b: Interval) -> Interval:
    """Return a bracket of a / b; refuses a divisor that may be zero."""
    if b[0] <= 0 <= b[1]:
        raise Refused("a division by an interval that contains zero")
    corners = [(x * ONE, y) for x in a for y in b]
    return held((min(x // y for x, y in corners), max(-(-x // y) for x, y in corners)))


def magnitude(a: Interval) -> int:
    """Return max |x|, as one integer over 10^36."""
    return max(-a[0], a[1])


def within(inner: Interval, low: Fraction, high: Fraction) -> bool:
    """Return whether the bracket certainly lies in [low, high]."""
    return (
        inner[0] * low.denominator >= low.numerator * ONE
        and inner[1] * high.denominator <= high.numerator * ONE
    )


def held(a: Interval) -> Interval:
    """Return the interval; refuses what is beyond 10^320."""
    if a[0] < -LARGEST or a[1] > LARGEST:
        raise Refused("a number beyond 10^320")
    return a
