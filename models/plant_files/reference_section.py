"""The section ``[reference]`` of a plant file -> the plant with integral states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.equations.ball import decimal_near
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.intervals.interval import Interval
from takagi.models.plant.variables import Reference, Variable

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.files.toml_document import Document
    from takagi.models.files.units import Unit
    from takagi.models.plant.entries import PlantEntry, ReferenceEntry
    from takagi.models.plant.plant import Plant

PLACE = "reference"


def with_references(
    document: Document, entry: PlantEntry, plant: Plant, unit_of: Callable[[str, str], Unit]
) -> Plant:
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
    found = []
    for name, given in entry.reference.items():
        place = f"{PLACE}.{name}"
        followed, si, written = _followed(document, place, entry, plant, given)
        unit = unit_of(f"{place}.unit", given.unit or written)
        if unit.dimension != unit_of(place, si).dimension:
            raise document.error(
                f"{place}.unit",
                f"{unit.text} was given, but {given.follow} is in {written}; give a unit that fits",
            )
        signal = _signal(
            document, place, name, given, unit, _rest(document, place, plant, followed)
        )
        integral = _integral(document, place, name, plant, unit.si)
        rate = None if given.rate is None else unit.to_si(Fraction(given.rate))
        if rate is not None and rate <= 0:
            raise document.error(f"{place}.rate", f"{given.rate} was given; a rate > 0 is needed")
        found.append(
            (Reference(name, integral.name, given.follow, rate), signal, integral, followed)
        )
    try:
        whole = following_plant(plant, found)
    except ModelError as error:
        raise document.error(PLACE, str(error)) from error
    try:
        held_rests(whole)
    except ModelError as error:
        name, _, words = str(error).partition(": ")
        raise document.error(f"{PLACE}.{name}.range", words) from error
    return whole


def _followed(
    document: Document, place: str, entry: PlantEntry, plant: Plant, given: ReferenceEntry
) -> tuple[sp.Expr, str, str]:
    """Return the expression that follows the reference, its SI unit, and its unit in the file."""
    outputs = {y.name: y for y in plant.outputs}
    states = {v.name: v for v in plant.states}
    if given.follow in states and given.follow not in entry.outputs:
        state = states[given.follow]
        return state.symbol, state.unit, state.written or state.unit
    if given.follow in outputs:
        output, stated = outputs[given.follow], entry.outputs.get(given.follow)
        return output.expression, output.unit, output.unit if stated is None else stated.unit
    known = {**states, **outputs}
    raise document.error(
        f"{place}.follow",
        f"there is no state or output {given.follow}{did_you_mean(given.follow, known)}; known are "
        + ", ".join(known),
    )


def _rest(document: Document, place: str, plant: Plant, followed: sp.Expr) -> Fraction:
    """Return the value of the following expression at the plant's rest."""
    import sympy as sp

    values = {v.symbol: sp.Rational(*v.rest.as_integer_ratio()) for v in plant.variables}
    values |= {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    found = sp.nsimplify(sp.sympify(followed).subs(values))
    if found.is_Rational:
        return Fraction(int(found.p), int(found.q))
    try:
        return decimal_near(found)[0]
    except ModelError as error:
        raise document.error(f"{place}.follow", f"at rest it has no value: {error}") from error


def _signal(
    document: Document, place: str, name: str, given: ReferenceEntry, unit: Unit, rest: Fraction
) -> Variable:
    low, high = given.range
    shown = "" if unit.text == "-" else f" {unit.text}"
    if low >= high:
        raise document.error(
            f"{place}.range", f"[{low}, {high}] was given; give the smaller end first"
        )
    side = Interval(unit.to_si(Fraction(low)), unit.to_si(Fraction(high)))
    if not side.lower <= rest <= side.upper:
        at = float(rest / unit.to_si(Fraction(1)))
        raise document.error(
            f"{place}.range",
            f"[{low}, {high}]{shown} was given, but at rest {given.follow} is {at:.6g}{shown}; "
            "give a range that contains it, or move the rest",
        )
    import sympy as sp

    symbol = sp.Symbol(name, real=True)
    return Variable(symbol, unit.si, side, rest, f"reference of {given.follow}", written=unit.text)


def _integral(document: Document, place: str, name: str, plant: Plant, unit: str) -> Variable:
    import sympy as sp

    own = f"{name}_integral"
    if own in {v.name for v in plant.variables} | {str(s) for s in plant.values}:
        raise document.error(place, f"its integral is called {own}, which is taken; rename one")
    return Variable(
        sp.Symbol(own, real=True),
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
