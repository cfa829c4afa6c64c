"""Ranges with slopes: forward differentiation on intervals, in floating point.

A ``Dual`` holds the range of a quantity over a box and, for each of a few directions, the range of
its derivative along that direction.  Sums, products and chains follow the rules of calculus, so a
formula written once gives its own enclosure and that of its Jacobian.  Functions with corners give
the hull of their one-sided slopes, which is what the mean value theorem asks of Lipschitz maps.

Rounding is not tracked (about 1e-13): what is emitted is widened by far more, and the exact
checker computes every range again in its own arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]
NOTHING: Range = (0.0, 0.0)


def times(a: Range, b: Range) -> Range:
    """Return the range of a product."""
    if a == NOTHING or b == NOTHING:
        return NOTHING
    corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return min(corners), max(corners)


def span(*values: float) -> Range:
    """Return the smallest range of all the values."""
    return min(values), max(values)


def hull(*ranges: Range) -> Range:
    """Return the smallest range of all the parts."""
    return min(p[0] for p in ranges), max(p[1] for p in ranges)


@dataclass(frozen=True, slots=True)
class Dual:
    """Range of a quantity, and of its derivative along each direction."""

    value: Range
    slopes: tuple[Range, ...]

    def __add__(self, other: Dual) -> Dual:
        value = (self.value[0] + other.value[0], self.value[1] + other.value[1])
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Dual(value, tuple((a[0] + b[0], a[1] + b[1]) for a, b in pairs))

    def __neg__(self) -> Dual:
        flipped = tuple((-b, -a) for a, b in self.slopes)
        return Dual((-self.value[1], -self.value[0]), flipped)

    def __sub__(self, other: Dual) -> Dual:
        return self + -other

    def __mul__(self, other: Dual) -> Dual:
        slopes = []
        for mine, theirs in zip(self.slopes, other.slopes, strict=True):
            a, b = times(mine, other.value), times(self.value, theirs)
            slopes.append((a[0] + b[0], a[1] + b[1]))
        return Dual(times(self.value, other.value), tuple(slopes))

    def scaled(self, factor: float) -> Dual:
        """Return factor times the quantity."""
        at = (factor, factor)
        return Dual(times(at, self.value), tuple(times(at, s) for s in self.slopes))

    def plus(self, offset: float) -> Dual:
        """Return the quantity plus a number."""
        return Dual((self.value[0] + offset, self.value[1] + offset), self.slopes)

    def through(self, value: Range, slope: Range) -> Dual:
        """Return f of the quantity, from the ranges of f and f' over ``value``."""
        return Dual(value, tuple(times(slope, s) for s in self.slopes))

    def inverse(self) -> Dual:
        """Return 1 over a quantity that keeps its sign.

        Raises
        ------
        ZeroDivisionError : the range holds 0.
        """
        low, high = self.value
        if low <= 0.0 <= high:
            raise ZeroDivisionError("a range that holds 0")
        value = (1.0 / high, 1.0 / low)
        size = times(value, value)
        return self.through(value, (-size[1], -size[0]))

    def held(self, low: float, high: float) -> Dual:
        """Return the quantity held to [low, high]; slope hull where it may touch an end."""
        a, b = self.value
        value = (min(max(a, low), high), min(max(b, low), high))
        if b <= low or a >= high:
            return self.through(value, NOTHING)
        return self.through(value, (1.0, 1.0) if low <= a and b <= high else (0.0, 1.0))


def constant(value: float, like: Dual) -> Dual:
    """Return a number as a quantity with the directions of another."""
    return Dual((value, value), (NOTHING,) * len(like.slopes))


def larger(a: Dual, b: Dual) -> Dual:
    """Return max(a, b)."""
    if a.value[0] >= b.value[1]:
        return a
    if b.value[0] >= a.value[1]:
        return b
    value = (max(a.value[0], b.value[0]), max(a.value[1], b.value[1]))
    return Dual(value, tuple(hull(s, t) for s, t in zip(a.slopes, b.slopes, strict=True)))


def smaller(a: Dual, b: Dual) -> Dual:
    """Return min(a, b)."""
    return -larger(-a, -b)
