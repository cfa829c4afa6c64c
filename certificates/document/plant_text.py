"""A plant's numbers, expressions and tables as a certificate writes them: in plain decimals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.splines.table_function import TableFunction


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


def tables_data(expressions: Iterable[sp.Expr]) -> dict[str, Any]:
    """Return the splines in the expressions, by name; empty if there are none."""
    from takagi.models.ranges.tape import tables_class

    tables = tables_class()
    if tables is None:
        return {}
    found: dict[str, type[TableFunction]] = {}
    for expression in expressions:
        for call in expression.atoms(tables):
            found[type(call).title] = type(call)
    return (
        {"tables": {name: _spline(kind) for name, kind in sorted(found.items())}} if found else {}
    )


def _spline(kind: type[TableFunction]) -> Mapping[str, Any]:
    from takagi.models.splines.curve import Curve

    table = kind.table
    if isinstance(table, Curve):
        knots = [table.knots.tolist()]
    else:
        knots = [table.x_knots.tolist(), table.y_knots.tolist()]
    return {
        "formula": "sum of coefficients times clamped cubic B-splines over the knots",
        "knots": knots,
        "coefficients": table.coefficients.tolist(),
    }
