"""Rational bounds of the exponential function."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused

__all__ = ["exp_above", "exp_below"]

LARGEST = 200
BITS = 200
ONE = 1 << BITS


def exp_below(x: Fraction) -> Fraction:
    """Return a rational r with 0 <= r < e^-x, for x >= 0; close to it up to x = 100, 0 from 200.

    e^(x/2^k) is at most the sum of x^j / (2^kj j!) up to j = d plus the last term, as each
    further term is less than half of the one before when x/2^k <= 1; squared k times and turned
    over.  Sums and squares are rounded up to 2^-200, the quotient down.

    Raises
    ------
    Refused : x is negative.
    """
    small, halvings = _halved(x)
    if x > LARGEST:
        return Fraction(0)
    share = _up(small.numerator << BITS, small.denominator)
    term, total, j = ONE, ONE, 0
    while term > 1:
        j += 1
        term = _up(term * share, j << BITS)
        total += term
    total += 2 * term + 1
    for _ in range(halvings):
        total = _up(total * total, ONE)
    return Fraction(ONE * ONE // total, ONE)


def exp_above(x: Fraction) -> Fraction:
    """Return a rational r > e^-x, for x >= 0, close to it up to x = 100: the same, rounded down.

    Any partial sum bounds e^(x/2^k) from below; beyond 200 the bound at 200 holds.
    """
    small, halvings = _halved(min(x, Fraction(LARGEST)))
    share = (small.numerator << BITS) // small.denominator
    term, total, j = ONE, ONE, 0
    while term:
        j += 1
        term = term * share // (j << BITS)
        total += term
    for _ in range(halvings):
        total = total * total >> BITS
    return Fraction(_up(ONE * ONE, total) + 1, ONE)


def _halved(x: Fraction) -> tuple[Fraction, int]:
    if x < 0:
        raise Refused("e^-x is bounded for x >= 0 only")
    halvings = 0
    while x > 1 << halvings:
        halvings += 1
    return x / (1 << halvings), halvings


def _up(numerator: int, denominator: int) -> int:
    return -(-numerator // denominator)
