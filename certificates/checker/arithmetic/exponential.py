"""The exponential function, rounded outward, on integers over 10^48."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused

FINE = 10**48
LARGEST = 700 * FINE  # of an argument: e^709 is the largest double
NEXT_TO_NOTHING = 200  # of x in e^-x, which no claim about a loop needs any closer


def exp_at(x: int) -> tuple[int, int]:
    """Return a bracket of exp(x); e^x = (e^(x / 2^m))^(2^m), by the series of positive terms.

    x and the bracket are over 10^48.

    Raises
    ------
    Refused : x is beyond 700 in size.
    """
    if abs(x) > LARGEST:
        raise Refused("exp of a number beyond 700")
    if x < 0:
        low, high = exp_at(-x)
        return FINE * FINE // high, -(-FINE * FINE // low)
    halvings = max(0, x.bit_length() - FINE.bit_length() + 5)
    y = x >> halvings
    total, term, n = 0, FINE, 0
    while term:
        total += term
        n += 1
        term = term * y // (FINE * n)
    # y <= 1/16: fewer than 40 terms, each rounded down by less than two units; what is left out
    # is below one unit; the bits of x that are shifted out are below one unit of y.
    low, high = total, total + 200
    for _ in range(halvings):
        low, high = low * low // FINE, -(-high * high // FINE)
    return low, high


def exp_below(x: Fraction) -> Fraction:
    """Return a rational r with 0 <= r < e^-x, x >= 0; tight for x <= 200, 0 for larger x.

    Raises
    ------
    Refused : x is negative.
    """
    _refuse_negative(x)
    if x > NEXT_TO_NOTHING:
        return Fraction(0)
    # A larger x and the upper end of e^x give a smaller e^-x: a lower bound.
    rounded_up = -(-x.numerator * FINE // x.denominator)
    return Fraction(FINE, exp_at(rounded_up)[1])


def exp_above(x: Fraction) -> Fraction:
    """Return a rational r >= e^-x, x >= 0; tight for x <= 200, constant for larger x.

    Raises
    ------
    Refused : x is negative.
    """
    _refuse_negative(x)
    bounded_x = min(x, Fraction(NEXT_TO_NOTHING))
    # A smaller x and the lower end of e^x give a larger e^-x: an upper bound.
    rounded_down = bounded_x.numerator * FINE // bounded_x.denominator
    return Fraction(FINE, exp_at(rounded_down)[0])


def _refuse_negative(x: Fraction) -> None:
    if x < 0:
        raise Refused("e^-x is bounded for x >= 0 only")
