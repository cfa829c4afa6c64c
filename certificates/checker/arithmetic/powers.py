"""Integer powers and roots of intervals; see ``interval``."""

from __future__ import annotations

from math import isqrt

from takagi.certificates.checker.arithmetic.interval import ONE, Exact, Interval
from takagi.certificates.checker.kernel.refusal import Refused


def whole_power(a: tuple[Exact, Exact], exponent: int) -> tuple[Exact, Exact]:
    """Return the range of x^n for a whole n > 0, over 10^(36 n) where the ends are over 10^36."""
    first, last = a[0] ** exponent, a[1] ** exponent
    if exponent % 2:
        return first, last
    # An even power is least at the point of the interval nearest to 0, which is 0 if it is inside.
    nearest_to_zero = max(a[0], -a[1], 0 * a[0])
    return nearest_to_zero**exponent, max(first, last)


def power(a: Interval, exponent: int) -> Interval:
    """Return a bracket of a^exponent for a whole exponent > 0; each end is rounded once."""
    low, high = whole_power(a, exponent)
    below = ONE ** (exponent - 1)
    return Interval(low // below, -(-high // below)).held()


def root(a: Interval, q: int) -> Interval:
    """Return a bracket of the q-th root >= 0; refuses an interval that may be negative."""
    if a[0] < 0:
        raise Refused("a root of what may be negative")
    scale = ONE ** (q - 1)
    # The root is rounded down; the upper end gets one unit more unless the root is exact.
    high = _root(a[1] * scale, q)
    return Interval(_root(a.low * scale, q), high + (high**q < a.high * scale))


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
