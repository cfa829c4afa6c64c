"""A plant's numbers and expressions as a certificate writes them: exactly, in plain decimals."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy as sp


def number_data(value: Fraction) -> float | int | str:
    """Return the number as a JSON number, or as text if no float prints it exactly."""
    if value.denominator == 1 and abs(value) < 10**15:
        return int(value)
    written = float(value)
    return written if Fraction(repr(written)) == value else str(value)


def rational_symbol(value: Fraction) -> sp.Rational:
    """Return the number as a SymPy number."""
    import sympy as sp

    return sp.Rational(value.numerator, value.denominator)


def text_data(expression: sp.Expr) -> str:
    """Return the expression in the grammar of plant files; its numbers are not shortened."""
    from takagi.models.equations.problem import cleaned

    return str(cleaned([expression], {})[0]).replace("**", "^").replace("Abs(", "abs(")
