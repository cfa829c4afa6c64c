"""Parameters of a plant file with a range, as signals that a law does not know.

An uncertain parameter p in [low, high] becomes a scheduling signal: the model covers every value in
the range.  A proved claim holds for each constant p, and also if p varies in its range in any way.
No gain may depend on p.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.intervals.interval import Interval
from takagi.models.plant.variables import Variable

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.files.toml_document import Document
    from takagi.models.files.units import Unit
    from takagi.models.plant.entries import ParameterEntry
    from takagi.models.plant.plant import Plant


def uncertain_parameter(
    document: Document,
    symbol: sp.Symbol,
    given: ParameterEntry,
    unit_of: Callable[[str, str], Unit],
) -> Variable:
    """Return the signal of a parameter with a range; it rests at its value, or in the middle.

    Raises
    ------
    ModelError : with file, line and field: ends in the wrong order or equal, a value that is an
        expression or outside the range.
    """
    assert given.range is not None  # called for such parameters only
    place, (low, high) = f"parameters.{symbol.name}", given.range
    text = given.unit or "-"
    shown = "" if text == "-" else f" {text}"
    if low > high:
        raise document.error(
            f"{place}.range", f"[{low}, {high}] was given; give the smaller end first"
        )
    if low == high:
        raise document.error(
            f"{place}.range",
            f"[{low}, {high}] has no width; write value = {low} for a parameter that is known",
        )
    if given.value is None:
        value = (Fraction(low) + Fraction(high)) / 2
    elif isinstance(given.value, Decimal):
        value = Fraction(given.value)
    else:
        raise document.error(
            f"{place}.value",
            f"{given.value!r} is an expression; an uncertain parameter has a range of its own, so "
            "give a number, or leave the range out: a derived parameter is as uncertain as those "
            "that it depends on",
        )
    if not low <= value <= high:
        raise document.error(
            f"{place}.value",
            f"{given.value}{shown} is outside the range [{low}, {high}]{shown}; give a value "
            "inside it, or leave the value out",
        )
    unit = unit_of(f"{place}.unit", text)
    return Variable(
        symbol,
        unit.si,
        Interval(unit.to_si(Fraction(low)), unit.to_si(Fraction(high))),
        unit.to_si(value),
        f"uncertain parameter{f': {given.source}' if given.source else ''}",
        schedules=True,
        unknown=True,
        written=text,
    )


def check_divisors(document: Document, plant: Plant) -> None:
    """Refuse ranges of uncertain parameters in which an equation divides by 0.

    Only divisors without states are tested here.  Divisors with states are tested when the bounds
    of the model are proved.

    Raises
    ------
    ModelError : with file, line and field of the first parameter in such a divisor.
    """
    import sympy as sp

    from takagi.models.ranges.expression_range import expression_range

    box = {v.symbol: v.range for v in plant.uncertain if v.range is not None}
    values = {s: sp.Rational(*value.as_integer_ratio()) for s, value in plant.values.items()}
    for variable, row in zip(plant.states, plant.equations, strict=True):
        for power in sorted(row.subs(values).atoms(sp.Pow), key=str):
            used = power.base.free_symbols
            if not power.exp.is_negative or not used or not used <= box.keys():
                continue
            found = expression_range(power.base, {s: box[s] for s in used}).outer
            if not found.contains(0):
                continue
            name = min(str(s) for s in used)
            ranges = ", ".join(f"{s} in {box[s]}" for s in sorted(used, key=str))
            raise document.error(
                f"parameters.{name}.range",
                f"the equation of {variable.name} divides by {power.base}, which may be 0 for "
                f"{ranges}; give a range in which it is not, or correct the equation",
            )
