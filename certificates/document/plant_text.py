"""A plant's numbers, expressions and tables as a certificate writes them: in plain decimals.

For a plant with two actuators the model of the certificate is the blended plant, with the share of
the high actuator and the errors of both as signals; the claim ``effort-blend`` ties it to the plant
with its two actuators.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.blending.blending import EFFORT, RATE, SHARE

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.blending.blending import Actuator, Blending
    from takagi.models.splines.table_function import TableFunction
    from takagi.models.ts.model import TSModel


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
    kinds: dict[str, type[TableFunction]] = {}
    for expression in expressions:
        for call in expression.atoms(tables):
            kinds[type(call).title] = type(call)
    return (
        {"tables": {name: _spline(kind) for name, kind in sorted(kinds.items())}} if kinds else {}
    )


def _spline(kind: type[TableFunction]) -> Mapping[str, Any]:
    from takagi.models.splines.spline import Curve

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


def blend_of(model: TSModel) -> Blending | None:
    """Return the blend of the plant that a model was derived from; None if it has none."""
    from takagi.models.blending.blending import blending_of

    form = None if model.derivation is None else model.derivation.form
    return None if form is None else blending_of(form.plant)


def unknown_premises(model: TSModel) -> list[bool]:
    """Return, for each premise, whether it depends on what a law does not know.

    That is an actuator's error, or an uncertain parameter.
    """
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return [False] * len(model.premises)
    blending, pushes = blend_of(model), form.problem.equations.disturbances
    unknown = {
        str(symbol)
        for variable, symbol in zip(form.plant.disturbances, pushes, strict=True)
        if variable.unknown
    }
    if blending is not None:
        unknown |= {a.error_name for a in blending.actuators if a.error}
    expressions = form.factored.premises.values()
    return [bool(unknown & {str(s) for s in e.free_symbols}) for e in expressions]


def blend_data(blending: Blending) -> dict[str, Any]:
    """Return the member ``blending`` of a certificate's model and law; numbers in SI."""
    plant = blending.plant
    return {
        "effort": EFFORT,
        "rate": RATE,
        "share": SHARE,
        "unit": blending.effort.unit,
        "overlap": number_data(blending.overlap),
        "low": _actuator(blending.low),
        "high": _actuator(blending.high),
        "equations": [text_data(row) for row in plant.equations],
    }


def blend_claim(model: TSModel) -> dict[str, Any]:
    """Return the claim without evidence: the checker bounds effectiveness by its own search."""
    name = f"{model.name or 'the plant'} behind its blend, with both actuators within their limits"
    return {"name": name, "kind": "effort-blend"}


def _actuator(actuator: Actuator) -> dict[str, Any]:
    side = actuator.variable.range
    return {
        "input": actuator.name,
        "unit": actuator.variable.unit,
        "direction": actuator.direction,
        "effectiveness": text_data(actuator.effectiveness),
        "idle": number_data(actuator.variable.rest),
        "range": None if side is None else [number_data(side.lower), number_data(side.upper)],
        "error": actuator.error_name if actuator.error else None,
    }
