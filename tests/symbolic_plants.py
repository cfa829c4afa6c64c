"""Plants from a few expressions, with a range for each variable that has one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp

from takagi.models import Interval, Output, Plant, Variable


def plant_of(
    f: Sequence[sp.Expr],
    states: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol] = (),
    *,
    box: Mapping[sp.Symbol, tuple[Any, Any]],
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    **members: Any,
) -> Plant:
    def variables(symbols: Sequence[sp.Symbol]) -> tuple[Variable, ...]:
        sides = [Interval.of(*box[s]) if s in box else None for s in symbols]
        return tuple(Variable(s, "-", side) for s, side in zip(symbols, sides, strict=True))

    return Plant(
        equations=tuple(map(sp.sympify, f)),
        states=variables(states),
        inputs=variables(inputs),
        disturbances=variables(disturbances),
        outputs=tuple(Output(f"y{k}", row) for k, row in enumerate(outputs, start=1)),
        **members,
    )
