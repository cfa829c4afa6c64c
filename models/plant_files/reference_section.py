"""The section ``[reference]`` of a plant file -> the plant with integral states."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import sympy as sp

from takagi.models.equations.equilibrium import decimal_near
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import Reference, Variable

if TYPE_CHECKING:
    from takagi.models.files.library import Document
    from takagi.models.files.units import Unit
    from takagi.models.plant.entries import PlantEntry, ReferenceEntry
    from takagi.models.plant.plant import Plant

SECTION = "reference"


def with_references(document: Document, entry: PlantEntry, plant: Plant) -> Plant:
    """Return the plant of a file with an integral state for each reference of the file.

    Raises
    ------
    ModelError : with file, line and field: an unknown name; a unit that does not fit; a reference
        whose range does not contain the rest; a reference whose equilibria are not within the
        ranges of states and inputs.
    """
    from takagi.models.tracking import following_plant, held_rests

    for parameter in plant.parameters:
        if parameter.within:
            raise document.error(
                f"parameters.{parameter.symbol}.value",
                f"it is no decimal ({parameter.equals}); in a plant that follows a reference every "
                f"parameter is one: give a number, such as {float(parameter.value):.9g}",
            )
    # The loop finds its rest by its integrals.  The plant's rest is the origin of deviations alone,
    # for which the decimals next to it do.
    states, inputs = (
        tuple(
            replace(v, rest=Fraction(repr(float(v.rest))), within=Fraction(0), equals=None)
            for v in group
        )
        for group in (plant.states, plant.inputs)
    )
    plant = replace(plant, states=states, inputs=inputs)
    references = []
    for name, reference in entry.reference.items():
        field = f"{SECTION}.{name}"
        followed, si, written = _followed(document, field, entry, plant, reference)
        unit = document.unit(f"{field}.unit", reference.unit or written)
        if unit.dimension != document.unit(field, si).dimension:
            raise document.error(
                f"{field}.unit",
                f"{unit.text} was given, but {reference.follow} is in {written}; "
                "give a unit that fits",
            )
        rest = _rest(document, field, plant, followed)
        signal = _signal(document, field, name, reference, unit, rest)
        integral = _integral(document, field, name, plant, unit.si)
        rate = None if reference.rate is None else unit.to_si(Fraction(reference.rate))
        if rate is not None and rate <= 0:
            raise document.error(
                f"{field}.rate", f"{reference.rate} was given; a rate > 0 is needed"
            )
        references.append(
            (Reference(name, integral.name, reference.follow, rate), signal, integral, followed)
        )
    with document.at(SECTION):
        with_integrals = following_plant(plant, references)
    try:
        held_rests(with_integrals)
    except ModelError as error:
        name, _, words = str(error).partition(": ")
        raise document.error(f"{SECTION}.{name}.range", words) from error
    return with_integrals


def _followed(
    document: Document, field: str, entry: PlantEntry, plant: Plant, reference: ReferenceEntry
) -> tuple[sp.Expr, str, str]:
    """Return the expression that follows the reference, its SI unit, and its unit in the file."""
    outputs = {y.name: y for y in plant.outputs}
    states = {v.name: v for v in plant.states}
    if reference.follow in states and reference.follow not in entry.outputs:
        state = states[reference.follow]
        return state.symbol, state.unit, state.written or state.unit
    if reference.follow in outputs:
        output, stated = outputs[reference.follow], entry.outputs.get(reference.follow)
        return output.expression, output.unit, output.unit if stated is None else stated.unit
    choices = {**states, **outputs}
    raise document.error(
        f"{field}.follow",
        f"there is no state or output {reference.follow}{did_you_mean(reference.follow, choices)}; "
        "known are " + ", ".join(choices),
    )


def _rest(document: Document, field: str, plant: Plant, followed: sp.Expr) -> Fraction:
    """Return the value of the following expression at the plant's rest."""
    value = sp.nsimplify(sp.sympify(followed).subs(plant.at_rest | plant.rationals))
    if value.is_Rational:
        return Fraction(int(value.p), int(value.q))
    try:
        return decimal_near(value)[0]
    except ModelError as error:
        raise document.error(f"{field}.follow", f"at rest it has no value: {error}") from error


def _signal(
    document: Document, field: str, name: str, reference: ReferenceEntry, unit: Unit, rest: Fraction
) -> Variable:
    low, high = reference.range
    unit_text = behind(unit.text)
    if low >= high:
        raise document.error(
            f"{field}.range", f"[{low}, {high}] was given; give the smaller end first"
        )
    side = Interval(unit.to_si(Fraction(low)), unit.to_si(Fraction(high)))
    if not side.lower <= rest <= side.upper:
        at = float(rest / unit.to_si(Fraction(1)))
        raise document.error(
            f"{field}.range",
            f"[{low}, {high}]{unit_text} was given, but at rest {reference.follow} is "
            f"{at:.6g}{unit_text}; give a range that contains it, or move the rest",
        )
    symbol = sp.Symbol(name, real=True)
    return Variable(
        symbol, unit.si, side, rest, f"reference of {reference.follow}", written=unit.text
    )


def _integral(document: Document, field: str, name: str, plant: Plant, unit: str) -> Variable:
    integral_name = f"{name}_integral"
    if integral_name in {v.name for v in plant.variables} | {str(s) for s in plant.values}:
        raise document.error(
            field, f"its integral is called {integral_name}, which is taken; rename one"
        )
    return Variable(
        sp.Symbol(integral_name, real=True),
        _times_second(unit),
        None,
        Fraction(0),
        f"integral of what is to follow {name}, less {name}; a state of the law",
    )


def _times_second(unit: str) -> str:
    """Return an SI unit times s."""
    if unit == "-":
        return "s"
    top, slash, bottom = unit.partition("/")
    return f"{top} s/{bottom}" if slash and top != "1" else f"s/{bottom}" if slash else f"{unit} s"
