"""Where a plant rests: checked exactly, or solved for the inputs that hold the states there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    import sympy as sp

EquilibriumOption: TypeAlias = Literal["given", "solve inputs"]
RESTS = ("given", "solve inputs")


def inputs_at_equilibrium(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr]
) -> dict[sp.Symbol, sp.Expr]:
    """Return u* with rows(x*, u*, w*) = 0 for the given x* and w*, exact expressions.

    Inputs that the rows leave free keep their given rest values.

    Raises
    ------
    ModelError : no inputs hold the states at the equilibrium, or an input enters nonlinearly.
    """
    import sympy as sp

    inputs = [v.symbol for v in plant.inputs]
    held = {symbol: value for symbol, value in rest.items() if symbol not in inputs}
    at_rest = [row.subs(held) for row in rows]
    try:
        slopes, offsets = sp.linear_eq_to_matrix(at_rest, inputs)
    except ValueError as error:
        raise ModelError(
            f"plant {plant.name!r}: the rest of the inputs was to be solved for, but an input "
            f"enters nonlinearly ({error}); give their rest values"
        ) from error
    solutions = list(sp.linsolve((slopes, offsets), *inputs))
    if not solutions:
        return {s: rest[s] for s in inputs}
    free = {s: rest[s] for s in inputs}
    return {s: value.subs(free) for s, value in zip(inputs, solutions[0], strict=True)}


def check_equilibrium(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr], how: EquilibriumOption
) -> None:
    """Raise ModelError unless every row vanishes at the equilibrium, exactly."""
    import sympy as sp

    for variable, row in zip(plant.states, rows, strict=True):
        residual = row.subs(rest)
        if residual == 0 or sp.simplify(residual) == 0:
            continue
        # Figures are SI, whatever unit the file has.
        where = ", ".join(f"{s} = {_short(value, 9)}" for s, value in rest.items())
        size = _short(residual, 6) if residual.is_finite else f"{residual}, not finite"
        what = "x(t + T) - x" if plant.sample_time is not None else "x'"
        unit = "" if variable.unit == "-" else f" {variable.unit}"
        size += unit if plant.sample_time is not None else f"{unit} per second"
        cure = (
            "no input makes it vanish; give rest values of the states at which one does"
            if how == "solve inputs"
            else "give rest values at which every row vanishes exactly, or let rest='solve inputs' "
            "(on the command line --solve-rest) find the inputs that hold the states there"
        )
        if not residual.is_rational or _has_table(row):
            # exp(350) is no decimal: a parameter that is its own equilibrium value can be.
            cure += (
                "; where no decimals do, write the equation with its value at rest, such as "
                "k*exp(b/T0 - b/T) for a*exp(-b/T), or f(p0) for what flows in"
            )
        raise ModelError(
            f"plant {plant.name!r}, equation of {variable.name}: at rest ({where}) {what} is "
            f"{size}, not 0, so the model cannot be written around this point; {cure}"
        )


def _short(value: sp.Expr, digits: int) -> str:
    import sympy as sp

    number = sp.N(value, digits)
    return f"{float(number):.{digits}g}" if number.is_real else str(number)


def _has_table(row: sp.Expr) -> bool:
    from takagi.models.ranges.table_balls import tables_class

    tables = tables_class()
    return tables is not None and row.has(tables)
