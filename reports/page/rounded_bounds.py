"""Numbers of proved bounds as text, rounded in the direction that keeps the sentence true.

Every reader of a verdict writes its bounds by these: terminal, page, appendix.  They are the
checker's own words (``takagi.certificates.checker.words.rounded``) for floats, each of which stands
for the decimal that it is written as.
"""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from math import ceil

from takagi.certificates.checker.words import rounded as shown

Bound = float | Fraction


def at_least(value: Bound, digits: int = 3) -> str:
    """Return the greatest decimal with these significant digits that does not exceed the value."""
    return shown.at_least(_exact(value), digits)


def at_most(value: Bound, digits: int = 3) -> str:
    """Return the least decimal of this many significant digits that is not below the value."""
    return shown.at_most(_exact(value), digits)


def at_most_to(value: Bound, decimals: int) -> str:
    """Return the least decimal with so many places that is not below the value, zeros kept."""
    return f"{Decimal(ceil(_exact(value) * 10**decimals)).scaleb(-decimals):f}"


def _exact(value: Bound) -> Fraction:
    return value if isinstance(value, Fraction) else Fraction(repr(float(value)))
