"""Sections and fields of a plant file: [tables], [design], ``measured`` and [blending]."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Literal

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.csv_table import read_curve, read_surface
from takagi.models.files.library import Document
from takagi.models.files.units import parse_unit
from takagi.models.plant.design_settings import PlantSettings, settling_rate
from takagi.models.plant.dimensions import dimension_of
from takagi.models.plant.entries import TableEntry
from takagi.models.plant.plant import Output
from takagi.models.splines.table_function import TableFunction, table_function

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.blending.blending import Actuator
    from takagi.models.plant.entries import ActuatorEntry, MeasuredEntry, PlantEntry, VariableEntry
    from takagi.models.plant.plant import Plant, Variable


def read_table(document: Document, name: str, table: TableEntry) -> type[TableFunction]:
    """Return the function of one or two arguments, in SI.

    Raises
    ------
    ModelError : the path, a unit, or the table itself is wrong.
    """
    path = table_path(document, name, table.file)
    value = document.unit(f"tables.{name}.unit", table.unit)
    field = f"tables.{name}.arguments"
    units = [document.unit(field, argument.unit) for argument in table.arguments]
    names = [f"{a.name} [{unit.si}]" for a, unit in zip(table.arguments, units, strict=True)]
    if len(units) == 1:
        curve = read_curve(path, name=name, units=(units[0], value), x_name=names[0])
        return table_function(name, curve, unit=value.si, argument_units=(units[0].si,))
    surface = read_surface(
        path, name=name, units=(units[0], units[1], value), axes=(names[0], names[1])
    )
    return table_function(name, surface, unit=value.si, argument_units=(units[0].si, units[1].si))


def table_path(document: Document, name: str, file: str) -> Path:
    """Return the path of the table's file, in the plant file's folder or below it.

    Raises
    ------
    ModelError : an absolute path, a path outside the folder (also by a link), a missing file.
    """
    field = f"tables.{name}.file"
    relative_path = PurePosixPath(file)
    if (
        relative_path.is_absolute()
        or ".." in relative_path.parts
        or "\\" in file
        or ":" in file
        or not file
    ):
        raise document.error(
            field,
            f"{file!r} was given; name a file in the folder of this one, or below it, with '/'",
        )
    folder = document.path.parent.resolve()
    path = (folder / relative_path).resolve()
    if not path.is_relative_to(folder):
        raise document.error(field, f"{file!r} leads out of the folder of this file; copy it there")
    if not path.is_file():
        raise document.error(field, f"{file!r} is not there; put the table beside this file")
    return document.path.parent / relative_path


TIME = re.compile(r"\s*([0-9]{0,9}\.?[0-9]{1,9}(?:[eE][-+]?[0-9]{1,2})?)\s*(.*?)\s*")


def seconds(document: Document, field: str, value: Decimal | str) -> Fraction:
    """Return a time in s, exactly.

    Raises
    ------
    ModelError : with file, line and field: a time that is not above 0, or a unit that is not one of
        time.
    """
    if isinstance(value, Decimal) and 0 < value < 10**99 and value.adjusted() > -99:
        return Fraction(value)
    written = str(value)
    match = TIME.fullmatch(written)
    if match is None or not float(match[1]) > 0:
        value_text = f"{written!r}" if isinstance(value, str) else written
        raise document.error(
            field, f'{value_text} was given; a time above 0 is needed, such as "2 s" or "5 min"'
        )
    unit = document.unit(field, match[2] or "s")
    if unit.dimension != parse_unit("s").dimension:
        raise document.error(field, f"{match[2]!r} is no unit of time; s, min and h are some")
    return unit.to_si(Fraction(match[1]))


_NUMBERS = ("gain_bound", "damping", "fastest", "horizon", "norm_below")


def settings_of(document: Document, entry: PlantEntry) -> PlantSettings:
    """Return the requirements of a plant's file on a design, in SI units.

    Limits and initial states are in the units that the file gives the variables.

    Raises
    ------
    ModelError : with file, line and field, as ``load_plant`` does; also a name that is no input or
        state, and numbers out of range.
    """
    design = entry.design
    rate: Decimal | float | Literal["max"] | None = design.decay_rate
    if design.settle is not None:
        field, written = "design.settle", str(design.settle)
        if rate is not None:
            raise document.error(
                field, "settle and decay_rate both say how fast the loop is; leave one out"
            )
        rate = settling_rate(float(seconds(document, field, written)))
    values = {name: _float(getattr(design, name)) for name in _NUMBERS}
    if design.sample_time is not None:
        values["sample_time"] = float(seconds(document, "design.sample_time", design.sample_time))
    limits = _in_si(document, "input_limit", design.input_limit, entry.commanded, "input")
    initial = _in_si(document, "initial", design.initial, entry.all_states, "state")
    noise = _in_si(document, "noise", design.noise, entry.disturbances, "disturbance")
    # Every message begins with the field's name.
    with document.at(lambda message: f"design.{message.split()[0]}"):
        settings = PlantSettings(
            choice=design.choice,
            rest=design.rest,
            decay_rate=_float(rate) if isinstance(rate, Decimal) else rate,
            effort=design.effort,
            relaxation=design.relaxation,
            safe_start=design.safe_start,
            input_limit=limits,
            initial=initial,
            noise=noise,
            objective=design.objective,
            performance=tuple(design.performance),
            disturbances=tuple(design.disturbances),
            feedback=() if design.controller is None else static_feedback(entry),
            order=getattr(design.controller, "order", 0),
            **values,
        )
        settings.require_names(**names_of(entry))
    return settings


def names_of(entry: PlantEntry) -> dict[str, tuple[str, ...]]:
    """Return the names of a plant's file, as ``PlantSettings.require_names`` takes them."""
    measured = [m.name for m in entry.measured or ()]
    return {
        "states": tuple(entry.all_states),
        "inputs": tuple(entry.commanded),
        "disturbances": tuple(entry.disturbances),
        "outputs": tuple(dict.fromkeys([*entry.outputs, *measured])),
    }


def static_feedback(entry: PlantEntry) -> tuple[str, ...]:
    """Return the names of what a law without observer has, the entries of ``measured``.

    Raises
    ------
    ModelError : there is no such field, or the plant follows references.
    """
    if not entry.measured or entry.reference:
        what = "follows references" if entry.reference else "has no field measured"
        raise ModelError(
            f"controller is for measured outputs, and the plant {what}; add "
            "measured = [...] with the states that a sensor shows, or leave controller out"
        )
    return tuple(m.name for m in entry.measured)


def _in_si(
    document: Document,
    field: str,
    entries: Mapping[str, Decimal],
    variables: Mapping[str, VariableEntry],
    kind: str,
) -> dict[str, float]:
    values = {}
    for name, value in entries.items():
        if name not in variables:
            raise document.error(
                f"design.{field}",
                f"{name} is no {kind}{did_you_mean(name, variables)}; {kind}s are "
                + (", ".join(variables) or "none"),
            )
        unit = document.unit(f"{kind}s.{name}.unit", variables[name].unit)
        values[name] = float(unit.to_si(Fraction(value)))
    return values


def _float(value: Decimal | None) -> float | None:
    return None if value is None else float(value)


FIELD = "measured"


def with_measured(
    document: Document, entry: PlantEntry, plant: Plant, read: Callable[[str, str], sp.Expr]
) -> Plant:
    """Return the plant with an output for each measured quantity, and the names of these outputs.

    An entry names an output, or a state; a state gets an output of the same name.

    ``read`` : place in the file and text -> expression.

    Raises
    ------
    ModelError : with file, line and field: an empty list; a name that is neither an output nor a
        state, or occurs twice; an expression with other variables than states and inputs; a plant
        with a blend.
    """
    assert entry.measured is not None  # checked by the caller
    if entry.blending is not None:
        raise document.error(
            FIELD, "output feedback is not for a plant with [blending]; leave one of them out"
        )
    if not entry.measured:
        raise document.error(
            FIELD, "nothing is measured; name outputs or states, or leave it out for all states"
        )
    if not plant.inputs:
        raise document.error(FIELD, "the plant has no input, so no law needs what is measured")
    outputs = list(plant.outputs)
    names: list[str] = []
    for measured in entry.measured:
        if measured.name in names:
            raise document.error(FIELD, f"{measured.name} stands in it twice; leave one out")
        names.append(measured.name)
        if measured.expression is None:
            added = _named(document, plant, outputs, measured)
        else:
            _check_new(document, plant, measured)
            expression = read(FIELD, measured.expression)
            added = Output(measured.name, expression, document.si_unit(FIELD, measured.unit))
        if added is not None:
            outputs.append(added)
    symbols = {v.symbol for v in (*plant.states, *plant.inputs)}
    symbols |= {p.symbol for p in plant.parameters}
    for output in outputs:
        strange = sorted(str(s) for s in output.expression.free_symbols - symbols)
        if output.name in names and strange:
            raise document.error(
                FIELD,
                f"{output.name} depends on {', '.join(strange)}, which comes from outside; "
                "what is measured is of states and inputs",
            )
    return replace(plant, outputs=tuple(outputs), measured=tuple(names))


def _named(
    document: Document, plant: Plant, outputs: Sequence[Output], measured: MeasuredEntry
) -> Output | None:
    """Return the output of a measured state; None for an output that the plant already has."""
    states = {v.name: v for v in plant.states}
    output_of = {y.name: y for y in outputs}
    state, output = states.get(measured.name), output_of.get(measured.name)
    if measured.unit != "-":
        raise document.error(FIELD, f"{measured.name} has a unit of its own; leave the unit out")
    if output is None and state is None:
        choices = (*output_of, *(name for name in states if name not in output_of))
        raise document.error(
            FIELD,
            f"{measured.name} is neither an output nor a state"
            f"{did_you_mean(measured.name, choices)}; those "
            f"are {', '.join(choices)}; of another quantity give name, expression and unit",
        )
    if output is None and state is not None:
        return Output(state.name, state.symbol, state.unit)
    if state is not None and output is not None and output.expression != state.symbol:
        raise document.error(
            FIELD, f"{measured.name} is a state and another output; rename the output in [outputs]"
        )
    return None


def _check_new(document: Document, plant: Plant, measured: MeasuredEntry) -> None:
    names = {v.name for v in plant.variables} | {p.symbol.name for p in plant.parameters}
    names |= {y.name for y in plant.outputs}
    if measured.name in names:
        raise document.error(
            FIELD, f"{measured.name} has a meaning already; give what is measured a name of its own"
        )


SECTION = "blending"
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

    blending = entry.blending
    assert blending is not None  # checked by the caller
    effort = variable(f"{SECTION}.effort", "effort", entry.all_states["effort"])
    rate = variable(f"{SECTION}.effort", "effort_rate", entry.commanded["effort_rate"])
    low = _actuator(document, "low", blending.low, plant, read)
    high = _actuator(document, "high", blending.high, plant, read)
    overlap = parse_unit(blending.effort.unit).to_si(Fraction(blending.effort.overlap))
    try:
        if plant.units == "checked":
            for name, actuator in (("low", low), ("high", high)):
                _check_unit(name, actuator, plant, effort)
        return blended_plant(Blending(effort, rate, overlap, low, high, plant))
    except ModelError as error:
        field, _, message = str(error).partition(": ")
        field_path = FIELDS.get(field, field)
        is_field = field_path in FIELDS.values() or field_path.split(".")[0] in ("low", "high")
        if is_field:
            raise document.error(f"{SECTION}.{field_path}", message) from error
        raise document.error(SECTION, str(error)) from error


def _actuator(
    document: Document,
    name: str,
    entry: ActuatorEntry,
    plant: Plant,
    read: Callable[[str, str], sp.Expr],
) -> Actuator:
    from takagi.models.blending.blending import Actuator

    inputs = {v.name: v for v in plant.inputs}
    if entry.input not in inputs:
        raise document.error(
            f"{SECTION}.{name}.input",
            f"{entry.input} is no input{did_you_mean(entry.input, inputs)}; inputs are "
            + (", ".join(inputs) or "none"),
        )
    effectiveness = read(f"{SECTION}.{name}.effectiveness", entry.effectiveness)
    variable, error = inputs[entry.input], Fraction(entry.error)
    return Actuator(variable, entry.direction, effectiveness, error)


def _check_unit(name: str, actuator: Actuator, plant: Plant, effort: Variable) -> None:
    """Refuse an effectiveness that is not effort per unit of its input."""
    units = {v.symbol: parse_unit(v.unit).dimension for v in plant.variables}
    units |= {p.symbol: parse_unit(p.unit).dimension for p in plant.parameters}
    owner = f"{name}.effectiveness"
    dimension = dimension_of(actuator.effectiveness, units, plant.values, owner=owner)
    input_dimension = parse_unit(actuator.variable.unit).dimension
    if (
        dimension is not None
        and dimension.times(input_dimension) != parse_unit(effort.unit).dimension
    ):
        raise ModelError(
            f"{owner}: it has the unit {dimension}; times the input's {actuator.variable.unit} "
            f"that is not the effort's {effort.unit}: correct the expression, or a unit"
        )
