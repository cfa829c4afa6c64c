"""Why outputs follow no reference, and which range to narrow by how much: found by trying."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.design.plant.tracking_gains import TrackingGains, tracking_gains
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.file_units import file_unit
from takagi.models.tracking import held_rests, own_states, signals_of

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

# What is left of a range's distance from rest: the first decides whether wider ones are tried.
LEFT = (Fraction(1, 10), Fraction(1, 2), Fraction(1, 4))


def tracking_obstacle(
    plant: Plant, asked: PlantSettings, found: TrackingGains, *, observed: bool
) -> str:
    """Return that no set was found, and which narrower ranges have one, each by itself."""
    words = "no set was found in which outputs follow their references within the ranges"
    design = found.found.design
    if not design.found:
        words = "no gain was found with which all slopes of the plant in its ranges settle"
        if design.answer.diagnosis:
            words += f" ({design.answer.diagnosis})"
    helps = [
        told for group in _groups(plant) if (told := _least(plant, group, asked, observed=observed))
    ]
    if helps:
        return f"{words}. A set is found with {'; or with '.join(helps)}. Change one of these"
    return (
        f"{words}, nor with all references, disturbances and ranges at a tenth of their distances "
        "from rest, one after the other. Move the rest to where the slopes of the equations are "
        "away from 0, or ask for less (decay_rate, input_limit)"
    )


def _groups(plant: Plant) -> Iterator[list[Variable]]:
    """Yield what is narrowed together: each signal, all, and what the slopes depend on likewise."""
    import sympy as sp

    signals = list(signals_of(plant))
    rows = sp.Matrix([sp.sympify(row) for row in plant.equations])
    own = [*plant.states, *plant.inputs]
    slopes = rows.jacobian([v.symbol for v in own])
    varying = [v for v in own if v.range is not None and v.symbol in slopes.free_symbols]
    for group in (signals, varying):
        for variable in group:
            yield [variable]
        if len(group) > 1:
            yield group


def _least(plant: Plant, group: list[Variable], asked: PlantSettings, *, observed: bool) -> str:
    """Return the widest of the narrower ranges with which a set is found, in words; else empty."""
    if not _works(plant, group, LEFT[0], asked, observed=observed):
        return ""
    wider = (left for left in LEFT[1:] if _works(plant, group, left, asked, observed=observed))
    left = next(wider, LEFT[0])
    return " and ".join(_told(v) for v in _narrowed(plant, group, left).values())


def _works(
    plant: Plant, group: list[Variable], left: Fraction, asked: PlantSettings, *, observed: bool
) -> bool:
    """Return whether a set is found if these ranges are narrowed."""
    moved = _narrowed(plant, group, left)
    narrow = replace(
        plant,
        states=tuple(moved.get(v.name, v) for v in plant.states),
        inputs=tuple(moved.get(v.name, v) for v in plant.inputs),
        disturbances=tuple(moved.get(v.name, v) for v in plant.disturbances),
    )
    try:
        held_rests(narrow)
        model = secant_model(narrow, rest=asked.rest)
        return tracking_gains(narrow, model, asked, observed=observed, few=True).jump > 0
    except ModelError:
        # The ranges no longer hold the rests at all references.
        return False


def _narrowed(plant: Plant, group: list[Variable], left: Fraction) -> dict[str, Variable]:
    """Return the variables with this share of the distance from where they rest to each end."""
    own = [plant.states[k] for k in own_states(plant)]
    values = held_rests(plant).values
    rests = {
        v.name: (Fraction(float(low)), Fraction(float(high)))
        for v, low, high in zip(
            (*own, *plant.inputs), values.min(axis=0), values.max(axis=0), strict=True
        )
    }
    found = {}
    for v in group:
        assert v.range is not None  # such variables are narrowed
        low, high = rests.get(v.name, (v.rest, v.rest))
        ends = (low + left * (v.range.lower - low), high + left * (v.range.upper - high))
        rounded = (Fraction(f"{float(end):.6g}") for end in ends)
        found[v.name] = replace(v, range=Interval(*rounded))
    return found


def _told(variable: Variable) -> str:
    assert variable.range is not None  # it was narrowed
    size, unit = file_unit(variable)
    low, high = (float(end) / size for end in (variable.range.lower, variable.range.upper))
    return f"{variable.name} in [{low:.4g}, {high:.4g}]{'' if unit == '-' else f' {unit}'}"
