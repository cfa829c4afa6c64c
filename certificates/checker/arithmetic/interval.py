"""Intervals: pairs of integers that bracket a number times 10^36, rounded outward.

Every operation rounds its lower end down and its upper end up, so the exact result lies inside.
Integers, not Fractions: no greatest common divisors and constant size.  A decimal grid, so that the
ends of a box and products of them are exact: a bound that is attained, such as x^2 <= 0.01 on
|x| <= 0.1, can be proved.

``add``, ``product`` and ``whole_power`` round nothing, and take ends that are fractions as well.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import TypeAlias, TypeVar

from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["ONE", "ZERO", "Ends", "Interval", "add", "div", "enclose", "hull", "magnitude", "mul"]
__all__ += ["neg", "point", "power", "product", "root", "square", "sub", "whole_power", "within"]

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
    return _held((low // ONE, -(-high // ONE)))


def whole_power(a: tuple[Exact, Exact], exponent: int) -> tuple[Exact, Exact]:
    """Return the range of x^n for a whole n > 0, over 10^(36 n) where the ends are over 10^36."""
    first, last = a[0] ** exponent, a[1] ** exponent
    if exponent % 2:
        return first, last
    least = first * 0 if a[0] <= 0 <= a[1] else min(first, last)
    return least, max(first, last)


def power(a: Interval, exponent: int) -> Interval:
    """Return a bracket of a^exponent for a whole exponent > 0; each end is rounded once."""
    low, high = whole_power(a, exponent)
    below = ONE ** (exponent - 1)
    return _held((low // below, -(-high // below)))


def square(a: Interval) -> Interval:
    return power(a, 2)


def div(a: Interval, b: Interval) -> Interval:
    """Return a bracket of a / b; refuses a divisor that may be zero."""
    if b[0] <= 0 <= b[1]:
        raise Refused("a division by an interval that contains zero")
    corners = [(x * ONE, y) for x in a for y in b]
    return _held((min(x // y for x, y in corners), max(-(-x // y) for x, y in corners)))


def root(a: Interval, q: int) -> Interval:
    """Return a bracket of the q-th root >= 0; refuses what may be negative."""
    if a[0] < 0:
        raise Refused("a root of what may be negative")
    scale = ONE ** (q - 1)
    high = _root(a[1] * scale, q)
    return _root(a[0] * scale, q), high + (high**q < a[1] * scale)


def _root(value: int, q: int) -> int:
    """Return the greatest integer whose q-th power does not exceed the value >= 0."""
    if q == 2:
        return isqrt(value)
    if value < 2:
        return value
    guess = 1 << -(-value.bit_length() // q)
    while True:
        better = ((q - 1) * guess + value // guess ** (q - 1)) // q
        if better >= guess:
            return guess
        guess = better


def magnitude(a: Interval) -> int:
    """Return max |x|, as one integer over 10^36."""
    return max(-a[0], a[1])


def within(inner: Interval, low: Fraction, high: Fraction) -> bool:
    """Return whether the bracket certainly lies in [low, high]."""
    return (
        inner[0] * low.denominator >= low.numerator * ONE
        and inner[1] * high.denominator <= high.numerator * ONE
    )


def _held(a: Interval) -> Interval:
    if a[0] < -LARGEST or a[1] > LARGEST:
        raise Refused("a number beyond 10^320")
    return a
