"""The section ``[blending]`` of a plant file -> the plant behind its blend."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.blending.blending import Actuator
    from takagi.models.files.toml_document import Document
    from takagi.models.plant.entries import ActuatorEntry, PlantEntry, VariableEntry
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

PLACE = "blending"
FIELDS = {"overlap": "effort.overlap", "effort": "effort.range"}


def behind_blend(
    document: Document,
    entry: PlantEntry,
    plant: Plant,
    variable: Callable[[str, str, VariableEntry], Variable],
    read: Callable[[str, str], sp.Expr],
) -> Plant:
    """Return the plant of a file, with its two actuators as inputs, behind the file's blend.

    Parameters
    ----------
    variable : place in the file, name and entry -> variable.
    read : place in the file and text -> expression.

    Raises
    ------
    ModelError : with file, line and field: an input that is not there, units of an effectiveness
        that do not fit, and whatever ``Blending`` and ``blended_plant`` refuse.
    """
    from takagi.models.blending.blending import Blending
    from takagi.models.blending.substitution import blended_plant
    from takagi.models.files.units import parse_unit

    given = entry.blending
    assert given is not None  # checked by the caller
    effort = variable(f"{PLACE}.effort", "effort", entry.all_states["effort"])
    rate = variable(f"{PLACE}.effort", "effort_rate", entry.commanded["effort_rate"])
    low = _actuator(document, "low", given.low, plant, read)
    high = _actuator(document, "high", given.high, plant, read)
    overlap = parse_unit(given.effort.unit).to_si(Fraction(given.effort.overlap))
    try:
        if plant.units == "checked":
            for name, actuator in (("low", low), ("high", high)):
                _check_unit(name, actuator, plant, effort)
        return blended_plant(Blending(effort, rate, overlap, low, high, plant))
    except ModelError as error:
        field, _, rest = str(error).partition(": ")
        place = FIELDS.get(field, field)
        known = place in FIELDS.values() or place.split(".")[0] in ("low", "high")
        if known:
            raise document.error(f"{PLACE}.{place}", rest) from error
        raise document.error(PLACE, str(error)) from error


def _actuator(
    document: Document,
    name: str,
    given: ActuatorEntry,
    plant: Plant,
    read: Callable[[str, str], sp.Expr],
) -> Actuator:
    from takagi.models.blending.blending import Actuator

    inputs = {v.name: v for v in plant.inputs}
    if given.input not in inputs:
        raise document.error(
            f"{PLACE}.{name}.input",
            f"{given.input} is no input{did_you_mean(given.input, inputs)}; inputs are "
            + (", ".join(inputs) or "none"),
        )
    effectiveness = read(f"{PLACE}.{name}.effectiveness", given.effectiveness)
    variable, error = inputs[given.input], Fraction(given.error)
    return Actuator(variable, given.direction, effectiveness, error)


def _check_unit(name: str, actuator: Actuator, plant: Plant, effort: Variable) -> None:
    """Refuse an effectiveness that is not effort per unit of its input."""
    from takagi.models.files.units import parse_unit
    from takagi.models.plant.dimensions import dimension_of

    units = {v.symbol: parse_unit(v.unit).dimension for v in plant.variables}
    units |= {p.symbol: parse_unit(p.unit).dimension for p in plant.parameters}
    place = f"{name}.effectiveness"
    found = dimension_of(actuator.effectiveness, units, plant.values, place=place)
    given = parse_unit(actuator.variable.unit).dimension
    if found is not None and found.times(given) != parse_unit(effort.unit).dimension:
        raise ModelError(
            f"{place}: it has the unit {found}; times the input's {actuator.variable.unit} that is "
            f"not the effort's {effort.unit}: correct the expression, or a unit"
        )
