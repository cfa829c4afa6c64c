"""Narrower ranges of a plant that follows references: its slopes vary less within them.

A set that stays in narrower ranges of states stays in the wider ones of the file, so that the claim
holds for the file's plant.  Slopes that vary less allow a larger set: a series motor, whose torque
is K i^2, may jump 12 times as far if the current stays in [2, 9] A in place of [0.5, 12] A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.equilibrium_line import own_states
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import file_unit
from takagi.models.tracking import held_rests

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant, Variable


def moving_slopes(plant: Plant) -> list[Variable]:
    """Return the states and inputs with a range on which slopes of the equations depend."""
    import sympy as sp

    rows = sp.Matrix([sp.sympify(row) for row in plant.equations])
    variables = [*plant.states, *plant.inputs]
    slopes = rows.jacobian([v.symbol for v in variables])
    return [v for v in variables if v.range is not None and v.symbol in slopes.free_symbols]


def with_ranges(plant: Plant, replaced: dict[str, Variable]) -> Plant:
    """Return the plant with these variables in the place of those of the same name."""
    return replace(
        plant,
        states=tuple(replaced.get(v.name, v) for v in plant.states),
        inputs=tuple(replaced.get(v.name, v) for v in plant.inputs),
        disturbances=tuple(replaced.get(v.name, v) for v in plant.disturbances),
    )


def narrowed(plant: Plant, group: Sequence[Variable], share: Fraction) -> dict[str, Variable]:
    """Return the variables with this share of the distance from where they rest to each end."""
    states = [plant.states[k] for k in own_states(plant)]
    values = held_rests(plant).values
    rests = {
        v.name: (Fraction(float(low)), Fraction(float(high)))
        for v, low, high in zip(
            (*states, *plant.inputs), values.min(axis=0), values.max(axis=0), strict=True
        )
    }
    narrower = {}
    for v in group:
        assert v.range is not None  # such variables are narrowed
        low, high = rests.get(v.name, (v.rest, v.rest))
        ends = (low + share * (v.range.lower - low), high + share * (v.range.upper - high))
        narrower[v.name] = replace(v, range=Interval(*(Fraction(f"{float(e):.6g}") for e in ends)))
    return narrower


def range_in_words(variable: Variable) -> str:
    """Return "w in [35, 130] rad/s", in the units of the file."""
    assert variable.range is not None  # it was narrowed
    size, unit = file_unit(variable)
    low, high = (float(end) / size for end in (variable.range.lower, variable.range.upper))
    return f"{variable.name} in [{low:.4g}, {high:.4g}]{'' if unit in ('', '-') else f' {unit}'}"
