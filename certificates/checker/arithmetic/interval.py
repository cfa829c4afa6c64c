"""Intervals: pairs of integers that bracket a number times 10^36, rounded outward.

Every operation rounds its lower end down and its upper end up, so the exact result lies inside.
Integers are used, not Fractions: they need no greatest common divisors and keep a constant size.
The grid is decimal, so the ends of a box and their products are exact. A bound that is attained,
such as x^2 <= 0.01 on |x| <= 0.1, can therefore be proved.

``product`` rounds nothing, and takes ends that are fractions as well.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple, TypeVar

from takagi.certificates.checker.kernel.refusal import Refused

ONE = 10**36
LARGEST = ONE * 10**320
Exact = TypeVar("Exact", int, Fraction)


class Interval(NamedTuple):
    """A bracket of one number; both ends over 10^36."""

    low: int
    high: int

    def __add__(self, other: Interval) -> Interval:  # type: ignore[override]
        return Interval(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Interval) -> Interval:
        return Interval(self.low - other.high, self.high - other.low)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Interval) -> Interval:  # type: ignore[override]
        """Return a bracket of the product."""
        low, high = product(self, other)
        # Floor for the lower end, ceiling for the upper end: the exact product lies in between.
        return Interval(low // ONE, -(-high // ONE)).held()

    def __truediv__(self, other: Interval) -> Interval:
        """Return a bracket of the quotient; refuses a divisor that may be zero."""
        if other.low <= 0 <= other.high:
            raise Refused("a division by an interval that contains zero")
        # -(-x // y) is the ceiling of x / y: floor for the lower end, ceiling for the upper end.
        corners = [(x * ONE, y) for x in self for y in other]
        return Interval(min(x // y for x, y in corners), max(-(-x // y) for x, y in corners)).held()

    def square(self) -> Interval:
        """Return a bracket of x^2, which is not negative."""
        return Interval(self.least() ** 2 // ONE, -(-(self.magnitude() ** 2) // ONE)).held()

    def magnitude(self) -> int:
        """Return max |x|, as one integer over 10^36."""
        return max(-self.low, self.high)

    def least(self) -> int:
        """Return min |x|, as one integer over 10^36."""
        return max(self.low, -self.high, 0)

    def within(self, low: Fraction, high: Fraction) -> bool:
        """Return whether the bracket certainly lies in [low, high]."""
        above = self.low * low.denominator >= low.numerator * ONE
        return above and self.high * high.denominator <= high.numerator * ONE

    def held(self) -> Interval:
        """Return the interval; refuses values beyond 10^320."""
        if self.low < -LARGEST or self.high > LARGEST:
            raise Refused("a number beyond 10^320")
        return self


ZERO, UNIT = Interval(0, 0), Interval(ONE, ONE)


def enclose(low: Fraction, high: Fraction) -> Interval:
    """Return the bracket of [low, high]."""
    # Floor for the lower end, ceiling for the upper end: rounded outward.
    down = low.numerator * ONE // low.denominator
    return Interval(down, -(-high.numerator * ONE // high.denominator))


def point(value: Fraction) -> Interval:
    """Return the bracket of one number."""
    return enclose(value, value)


def hull(*brackets: Interval) -> Interval:
    """Return the smallest interval that contains all brackets."""
    return Interval(min(p.low for p in brackets), max(p.high for p in brackets))


def product(a: tuple[Exact, Exact], b: tuple[Exact, Exact]) -> tuple[Exact, Exact]:
    """Return the range of x y, over 10^72 where the ends are over 10^36."""
    if a[0] >= 0 and b[0] >= 0:
        return a[0] * b[0], a[1] * b[1]
    corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return min(corners), max(corners)
