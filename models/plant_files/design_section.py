"""The section ``[design]`` of a plant file -> ``PlantSettings``."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import parse_unit
from takagi.models.plant.design_settings import PlantSettings, settling_rate
from takagi.models.plant_files.written_time import seconds

if TYPE_CHECKING:
    from takagi.models.files.toml_document import Document
    from takagi.models.plant.entries import DesignEntry, PlantEntry, VariableEntry

_NUMBERS = ("gain_bound", "damping", "fastest", "horizon")


def settings_of(document: Document, entry: PlantEntry) -> PlantSettings:
    """Return the requirements of a plant's file on a design, in SI units.

    Limits and initial states are in the units that the file gives the variables.

    Raises
    ------
    ModelError : with file, line and field, as ``load_plant`` does; also a name that is no input or
        state, and numbers out of range.
    """
    asked = entry.design
    rate = asked.decay_rate if asked.settle is None else _settling_rate(document, asked)
    values = {name: _float(getattr(asked, name)) for name in _NUMBERS}
    if asked.sample_time is not None:
        values["sample_time"] = float(seconds(document, "design.sample_time", asked.sample_time))
    limits = _in_si(document, "input_limit", asked.input_limit, entry.commanded, "input")
    initial = _in_si(document, "initial", asked.initial, entry.all_states, "state")
    noise = _in_si(document, "noise", asked.noise, entry.disturbances, "disturbance")
    try:
        found = PlantSettings(
            choice=asked.choice,
            rest=asked.rest,
            decay_rate=_float(rate) if isinstance(rate, Decimal) else rate,
            effort=asked.effort,
            relaxation=asked.relaxation,
            input_limit=limits,
            initial=initial,
            noise=noise,
            **values,
        )
        found.require_names(
            states=tuple(entry.all_states),
            inputs=tuple(entry.commanded),
            disturbances=tuple(entry.disturbances),
        )
    except ModelError as error:
        # Every message begins with the field's name.
        field = str(error).split()[0]
        raise document.error(f"design.{field}", str(error)) from error
    return found


def _in_si(
    document: Document,
    field: str,
    given: Mapping[str, Decimal],
    variables: Mapping[str, VariableEntry],
    what: str,
) -> dict[str, float]:
    found = {}
    for name, value in given.items():
        if name not in variables:
            raise document.error(
                f"design.{field}",
                f"{name} is no {what}{did_you_mean(name, variables)}; {what}s are "
                + (", ".join(variables) or "none"),
            )
        try:
            unit = parse_unit(variables[name].unit)
        except ModelError as error:
            raise document.error(f"{what}s.{name}.unit", str(error)) from error
        found[name] = float(unit.to_si(Fraction(value)))
    return found


def _settling_rate(document: Document, asked: DesignEntry) -> float:
    """Return the decay rate [1/s] that ``settle`` means."""
    field, written = "design.settle", str(asked.settle)
    if asked.decay_rate is not None:
        raise document.error(
            field, "settle and decay_rate both say how fast the loop is; leave one out"
        )
    return settling_rate(float(seconds(document, field, written)))


def _float(value: Decimal | None) -> float | None:
    return None if value is None else float(value)
