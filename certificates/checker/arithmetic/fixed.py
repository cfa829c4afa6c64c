"""Intervals in fixed point: pairs of integers that bracket a number times 2^96.

Every operation rounds its lower end down and its upper end up, so the exact result lies inside.
Integers, not Fractions: no greatest common divisors, constant size, a hundred times faster.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["BITS", "ONE", "ZERO", "Q", "add", "div", "enclose", "hull", "magnitude", "mul", "neg"]
__all__ += ["point", "square", "sub", "within"]

BITS = 96
ONE = 1 << BITS
Q = tuple[int, int]
ZERO: Q = (0, 0)


def enclose(low: Fraction, high: Fraction) -> Q:
    """Return the bracket of [low, high]."""
    down = (low.numerator << BITS) // low.denominator
    return down, -((-high.numerator << BITS) // high.denominator)


def point(value: Fraction) -> Q:
    """Return the bracket of one number."""
    return enclose(value, value)


def hull(*parts: Q) -> Q:
    """Return the smallest bracket of all parts."""
    return min(p[0] for p in parts), max(p[1] for p in parts)


def add(a: Q, b: Q) -> Q:
    return a[0] + b[0], a[1] + b[1]


def sub(a: Q, b: Q) -> Q:
    return a[0] - b[1], a[1] - b[0]


def neg(a: Q) -> Q:
    return -a[1], -a[0]


def mul(a: Q, b: Q) -> Q:
    """Return a bracket of the product; >> rounds down for either sign."""
    if a[0] >= 0 and b[0] >= 0:
        return a[0] * b[0] >> BITS, -(-a[1] * b[1] >> BITS)
    corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return min(corners) >> BITS, -(-max(corners) >> BITS)


def square(a: Q) -> Q:
    low, high = sorted((abs(a[0]), abs(a[1])))
    least = 0 if a[0] <= 0 <= a[1] else low * low >> BITS
    return least, -(-high * high >> BITS)


def div(a: Q, b: Q) -> Q:
    """Return a bracket of a / b; refuses a divisor that may be zero."""
    if b[0] <= 0 <= b[1]:
        raise Refused("a division by an interval that contains zero")
    corners = [(x << BITS, y) for x in a for y in b]
    low = min(x // y for x, y in corners)
    high = max(-((-x) // y) for x, y in corners)
    return low, high


def magnitude(a: Q) -> int:
    """Return max |x|, as one integer over 2^96."""
    return max(-a[0], a[1])


def within(inner: Q, low: Fraction, high: Fraction) -> bool:
    """Return whether the bracket certainly lies in [low, high]."""
    return (
        inner[0] * low.denominator >= low.numerator << BITS
        and inner[1] * high.denominator <= high.numerator << BITS
    )
