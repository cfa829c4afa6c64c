"""Checks of a plant file: its entries in words, and the ranges of its tables.

The arguments of every table must stay inside it on the whole box.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import sympy as sp

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    from pydantic import BaseModel

    from takagi.models.plant.plant import Plant


VARIABLE = '{ unit = "m", range = [-1, 1] }'
EXAMPLES = {
    "states": VARIABLE,
    "inputs": VARIABLE,
    "disturbances": VARIABLE,
    "scheduling": VARIABLE,
    "parameters": '{ value = 9.81, unit = "m/s^2", source = "..." }',
    "outputs": '{ expression = "x", unit = "m" }',
    "tables": '{ file = "table.csv", unit = "N", arguments = [{ name = "x", unit = "m" }] }',
    "mass": '{ x = "m*l^2" }',
    "reference": '{ follow = "x", range = [-1, 1] }',
}


def problem_of(error: Mapping[str, Any], field: str) -> str:
    """Return the message for one validation error of pydantic, and its field."""
    from takagi.models.plant import entries as e

    kind, message = error["type"], error["msg"]
    section, _, key = field.rpartition(".")
    if kind == "extra_forbidden":
        inner = (e.VariableEntry, e.ParameterEntry, e.OutputEntry, e.TableEntry, e.ReferenceEntry)
        special: dict[str, tuple[type[BaseModel], ...]]
        special = {"": (e.PlantEntry,), "design": (e.DesignEntry,)}
        entry_types = special.get(section, inner)
        fields = {name: None for entry in entry_types for name in entry.model_fields}
        return f"is not known{did_you_mean(key, fields)}; correct its name, or remove it"
    if kind == "missing" and section.endswith(".range"):
        return "a range has two numbers; write range = [low, high]"
    if field == "format":
        found = "is missing" if kind == "missing" else f"{error['input']!r} was given"
        return f"{found}; this takagi reads format = 1: write it so, or use a newer takagi"
    if kind == "missing":
        return "is missing; add it"
    if kind == "literal_error" and field.startswith("reference.") and key == "integral":
        return (
            f"{error['input']} was given; without an integral an error stays that no gain can say, "
            "so references are followed with one: leave the field out"
        )
    if kind == "string_pattern_mismatch":
        return "a name starts with a letter and has letters a-z, A-Z, digits and _; rename it"
    if kind in ("model_type", "dict_type"):
        return _fields_wanted(error["input"], field)
    if kind == "string_type":
        return f"{error['input']} was given; a text in quotes is needed"
    if kind in ("tuple_type", "too_long") and key == "range":
        return "a range has two numbers; write range = [low, high]"
    return str(message).removeprefix("Value error, ")


def _fields_wanted(value: object, field: str) -> str:
    """Return what to write if fields in braces, or a section, were expected."""
    section, _, name = field.partition(".")
    value_text = f'"{value}"' if isinstance(value, str) else str(value)
    if section in EXAMPLES and name:
        return f"{value_text} was given; fields are needed, such as {name} = {EXAMPLES[section]}"
    return f"{value_text} was given; a section is needed: a line [{field}], and its fields below"


TOLERANCE = Fraction(1, 10**6)


def check_coverage(plant: Plant) -> None:
    """Raise ModelError unless each argument of each table provably stays inside it on the box.

    The range of an argument is enclosed rigorously; one that only touches the edge of its table
    may be refused, because its enclosure is wider by a millionth of its width.  In f(g(x)) the
    argument of g is examined first, because a range of g(x) is defined only inside g.
    """
    from takagi.models.splines.table_function import TableFunction, table_ranges

    checked_calls: set[Any] = set()
    for owner, expression in plant.expressions:
        calls = expression.atoms(TableFunction)
        for call in sorted(calls, key=lambda c: (len(c.atoms(TableFunction)), str(c))):
            if call in checked_calls:
                continue
            checked_calls.add(call)
            pairs = zip(call.args, table_ranges(call.table), strict=True)
            for number, (argument, covered) in enumerate(pairs, start=1):
                _check(plant, f"{owner}: argument {number} of {call}", argument, covered)


def _check(
    plant: Plant,
    owner: str,
    argument: sp.Expr,
    covered: Interval,
) -> None:
    attained = _range(plant, owner, argument.subs(plant.rationals))
    if covered.contains(attained):
        return
    named = sorted(str(symbol) for symbol in argument.free_symbols)
    sides = ", ".join(
        f"{variable.name} in {variable.range}"
        for variable in plant.variables
        if variable.name in named and variable.range is not None
    )
    raise ModelError(
        f"{owner}, {argument}, takes values in {attained} on the box "
        f"({sides or 'a number'}), but the "
        f"table covers {covered}; shrink the ranges or extend the table"
    )


def _range(plant: Plant, owner: str, argument: sp.Expr) -> Interval:
    ranges = {variable.symbol: variable.range for variable in plant.variables}
    missing = sorted(str(s) for s in argument.free_symbols if ranges[s] is None)
    if missing:
        raise ModelError(
            f"{owner}, {argument}, depends on {', '.join(missing)}, which has no range; give one"
        )
    if argument.is_Symbol:
        return plant.box[argument]
    try:
        return expression_range(argument, plant.box, tolerance=TOLERANCE).outer
    except ModelError as error:
        raise ModelError(f"{owner}: its range cannot be enclosed: {error}") from error
