"""Enclosures of a quantity and its slopes: forward differentiation in fixed point.

``Dual`` holds an enclosure of a quantity over a box and one of its derivative along each direction.
For functions with corners it encloses all one-sided derivatives, as the mean value theorem
requires.
"""

from __future__ import annotations

from dataclasses import dataclass

from takagi.certificates.checker.arithmetic.interval import UNIT, ZERO, Interval, hull


@dataclass(frozen=True)
class Dual:
    """A bracket and its slopes."""

    value: Interval
    slopes: tuple[Interval, ...]

    def __add__(self, other: Dual) -> Dual:
        slopes = tuple(s + t for s, t in zip(self.slopes, other.slopes, strict=True))
        return Dual(self.value + other.value, slopes)

    def __neg__(self) -> Dual:
        return Dual(-self.value, tuple(-slope for slope in self.slopes))

    def __sub__(self, other: Dual) -> Dual:
        return self + -other

    def __mul__(self, other: Dual) -> Dual:
        a, b = self.value, other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        slopes = tuple(_product(s, b) + _product(a, t) for s, t in pairs)
        return Dual(a * b, slopes)

    def __truediv__(self, other: Dual) -> Dual:
        inverse = UNIT / other.value
        return self * other.through(inverse, -inverse.square())

    def through(self, value: Interval, slope: Interval) -> Dual:
        """Return f of the quantity from brackets of f and of f' over it."""
        return Dual(value, tuple(_product(slope, s) for s in self.slopes))

    def by(self, factor: Interval) -> Dual:
        """Return the quantity times a number."""
        return Dual(self.value * factor, tuple(_product(factor, s) for s in self.slopes))

    def plus(self, number: Interval) -> Dual:
        """Return the quantity plus a number."""
        return Dual(self.value + number, self.slopes)

    def clamped(self, low: Interval, high: Interval) -> Dual:
        """Return the quantity clamped to [low, high]; both ends are known as brackets."""
        return lesser(greater(self, still(low, self)), still(high, self))


def still(value: Interval, like: Dual) -> Dual:
    """Return a number, which has no slopes."""
    return Dual(value, (ZERO,) * len(like.slopes))


def greater(a: Dual, b: Dual) -> Dual:
    """Return the larger of two quantities."""
    if a.value[0] >= b.value[1]:
        return a
    if b.value[0] >= a.value[1]:
        return b
    value = Interval(max(a.value.low, b.value.low), max(a.value.high, b.value.high))
    return Dual(value, tuple(map(hull, a.slopes, b.slopes)))


def lesser(a: Dual, b: Dual) -> Dual:
    """Return the smaller of two quantities."""
    return -greater(-a, -b)


def chained(value: Interval, *terms: tuple[Interval, Dual]) -> Dual:
    """Return a function of several quantities: sum of partial times inner slope, per direction."""
    slopes = []
    for k in range(len(terms[0][1].slopes)):
        total = ZERO
        for partial, inner in terms:
            total = total + _product(partial, inner.slopes[k])
        slopes.append(total)
    return Dual(value, tuple(slopes))


def _product(a: Interval, b: Interval) -> Interval:
    return ZERO if a == ZERO or b == ZERO else a * b
