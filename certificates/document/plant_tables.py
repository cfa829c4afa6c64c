"""The tables in a plant's expressions, as a certificate states them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.splines.table_function import TableFunction


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
