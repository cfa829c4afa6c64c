"""Exact numbers as short decimals, rounded in the direction that keeps a sentence true."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal, Inexact
from fractions import Fraction

# Products of a few numbers from the reader have fewer digits than this limit.
MANY = 400


def at_least(value: Fraction, digits: int) -> str:
    """Return the greatest decimal of this many digits that does not exceed the value."""
    return _shown(value, Context(prec=digits, rounding=ROUND_FLOOR))


def at_most(value: Fraction, digits: int) -> str:
    """Return the least decimal of this many digits that is not below the value."""
    return _shown(value, Context(prec=digits, rounding=ROUND_CEILING))


def exactly(value: Fraction) -> str:
    """Return a number that may not be rounded to either side: its decimals, or a fraction."""
    context = Context(prec=MANY)
    decimals = _shown(value, context)
    return f"({value.numerator}/{value.denominator})" if context.flags[Inexact] else decimals


def _shown(value: Fraction, context: Context) -> str:
    # Decimal division rounds once, in the context's direction.
    quotient = context.divide(Decimal(value.numerator), Decimal(value.denominator))
    return f"{quotient.normalize():f}" if -6 < quotient.adjusted() < 12 else f"{quotient:e}"


def range_within(low: Fraction, high: Fraction, digits: int = 6) -> str:
    """Return a range that is not wider than the exact one, e.g. ``3 to 4.5``."""
    return f"{at_most(low, digits)} to {at_least(high, digits)}"


def range_around(low: Fraction, high: Fraction) -> str:
    """Return a range that is not narrower than the exact one."""
    return f"{at_least(low, 6)} to {at_most(high, 6)}"
