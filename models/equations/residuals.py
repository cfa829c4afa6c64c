"""The residuals of a plant's equations at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.equations.ball import Ball
from takagi.models.equations.equilibrium import equilibrium_text, residual_text
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.plant.variables import Variable

if TYPE_CHECKING:
    import sympy as sp


def residuals(
    plant: Plant, f: Sequence[sp.Expr], mass: sp.Matrix | None, rest: Mapping[sp.Symbol, sp.Expr]
) -> list[sp.Expr]:
    """Return the rows of f at rest, in discrete time less M x*: 0 where the plant rests.

    Raises
    ------
    ModelError : a row that has no value there as it is written, such as sin(x)/x at 0.
    """
    import sympy as sp

    left = sp.zeros(len(f), 1)
    if plant.sample_time is not None:
        left = sp.Matrix([rest[v.symbol] for v in plant.states])
        left = left if mass is None else mass * left
    found = [(row - part).subs(rest) for row, part in zip(f, left, strict=True)]
    for variable, row in zip(plant.states, found, strict=True):
        if row.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
            raise ModelError(
                f"plant {plant.name!r}, equation of {variable.name}: it divides by 0 at rest, so "
                "that no rest can be found from it; write it without that quotient, or give all "
                "rests as numbers"
            )
    return found


def require_zero(plant: Plant, left: Sequence[sp.Expr], balls: Mapping[sp.Symbol, Ball]) -> None:
    """Raise ModelError, with every residual, unless each may be 0 in the balls."""
    from takagi.models.ranges.expression_range import expression_range

    box = {ball.symbol: ball.side for ball in balls.values()}
    ranges = [expression_range(row, {s: box[s] for s in row.free_symbols}).outer for row in left]
    if all(found.contains(0) for found in ranges):
        return
    sizes = {v: found.centre for v, found in zip(plant.states, ranges, strict=True)}
    refuse_residuals(plant, sizes, {v.symbol: v.rest for v in plant.variables}, "give another rest")


def refuse_residuals(
    plant: Plant,
    sizes: Mapping[Variable, Fraction | None],
    at: Mapping[sp.Symbol, Fraction],
    advice: str,
) -> None:
    """Raise ModelError with every residual that is not 0, its equation and its unit."""
    import sympy as sp

    told = [
        f"{v.name}' has no value"
        if size is None
        else residual_text(plant, v, sp.Float(float(size)))
        for v, size in sizes.items()
        if size is None or abs(size) > 0
    ]
    where = equilibrium_text({s: sp.Float(float(v)) for s, v in at.items()})
    raise ModelError(f"plant {plant.name!r}: at ({where}) {'; '.join(told)}; {advice}")
