"""Positive rationals as products of powers, so that sqrt(2) sqrt(3) and sqrt(6) are one."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from math import isqrt

__all__ = ["exact_root", "factors"]

MOST_FACTOR = 10_000  # tried as a divisor
MOST_BITS = 256  # of a number that is taken apart


def factors(value: Fraction) -> list[tuple[int, int]]:
    """Return different whole numbers > 1 with powers, whose product is the value > 0.

    They are primes but for one that is left when all small ones are found, and for a number too
    large to be taken apart: the product is exact all the same.
    """
    found = Counter[int]()
    for number, sign in ((value.numerator, 1), (value.denominator, -1)):
        left, factor = number, 2
        while number.bit_length() <= MOST_BITS and factor <= min(MOST_FACTOR, isqrt(left)):
            while left % factor == 0:
                found[factor] += sign
                left //= factor
            factor += 1
        if left > 1:
            found[left] += sign
    return sorted((factor, power) for factor, power in found.items() if power)


def exact_root(value: Fraction, q: int) -> Fraction | None:
    """Return the square root of a rational where it is rational; None otherwise."""
    if q != 2 or value < 0:
        return None
    top, bottom = isqrt(value.numerator), isqrt(value.denominator)
    exact = top * top == value.numerator and bottom * bottom == value.denominator
    return Fraction(top, bottom) if exact else None
