"""Intervals on a decimal grid: pairs of integers that bracket a number times 10^36.

Decimal, so that the ends of a box and products of them are exact: a bound that is attained, such
as x^2 <= 0.01 on |x| <= 0.1, can be proved.  Every operation rounds its lower end down and its
upper end up.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import TypeAlias

from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["ONE", "Pair", "add", "divide", "enclose", "exact", "hull", "multiply", "power"]
__all__ += ["root", "scaled_up"]

DIGITS = 36
ONE = 10**DIGITS
LARGEST = ONE * 10**320
Pair: TypeAlias = tuple[int, int]


def enclose(low: Fraction, high: Fraction) -> Pair:
    """Return the bracket of [low, high]."""
    return (
        low.numerator * ONE // low.denominator,
        -(-high.numerator * ONE // high.denominator),
    )


def exact(value: Fraction) -> Pair:
    """Return the bracket of one number."""
    return enclose(value, value)


def hull(a: Pair, b: Pair) -> Pair:
    return min(a[0], b[0]), max(a[1], b[1])


def add(a: Pair, b: Pair) -> Pair:
    return a[0] + b[0], a[1] + b[1]


def multiply(a: Pair, b: Pair) -> Pair:
    if a[0] >= 0 and b[0] >= 0:
        low, high = a[0] * b[0], a[1] * b[1]
    else:
        corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
        low, high = min(corners), max(corners)
    return _held((low // ONE, -(-high // ONE)))


def divide(a: Pair, b: Pair) -> Pair:
    """Return a / b; refuses a divisor that may be 0."""
    if b[0] <= 0 <= b[1]:
        raise Refused("a division by what may be zero")
    corners = [(x * ONE, y) for x in a for y in b]
    return _held((min(x // y for x, y in corners), max(-(-x // y) for x, y in corners)))


def power(a: Pair, exponent: int) -> Pair:
    """Return a^exponent for a whole exponent > 0; each end is rounded once."""
    below = ONE ** (exponent - 1)
    first, last = a[0] ** exponent, a[1] ** exponent
    if exponent % 2 == 0:
        least = 0 if a[0] <= 0 <= a[1] else min(first, last)
        return _held((least // below, -(-max(first, last) // below)))
    return _held((first // below, -(-last // below)))


def root(a: Pair, q: int) -> Pair:
    """Return the q-th root >= 0; refuses what may be negative."""
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


def scaled_up(a: Pair, factor: int) -> Pair:
    """Return a times a whole number >= 0, exactly."""
    return a[0] * factor, a[1] * factor


def _held(a: Pair) -> Pair:
    if a[0] < -LARGEST or a[1] > LARGEST:
        raise Refused("a number beyond 10^320")
    return a
