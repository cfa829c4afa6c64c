"""Numbers of a gain file: their exact values, and the short decimals that programs read."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import Number


def exact(value: Any) -> Fraction:
    """Return a number exactly; a text without names, such as ``"sqrt(2)"``, to 36 places.

    Of a number with a ball the decimal is returned.
    """
    if isinstance(value, dict):
        return exact(value["value"])
    if isinstance(value, str) and not isinstance(value, Number):
        # Imported here: few numbers are written as text.
        from takagi.certificates.checker.plant.reading import constant_bracket

        return sum(constant_bracket(value), Fraction(0)) / 2
    return Fraction(value if isinstance(value, str) else repr(value))


def short(value: Fraction) -> Number:
    """Return the shortest decimal of the nearest float, which a program computes with."""
    return Number(repr(float(value)))
