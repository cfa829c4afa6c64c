"""Messages about wrong fields of a plant file: the given content, and what to write instead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from takagi.models.errors import did_you_mean

if TYPE_CHECKING:
    from pydantic import BaseModel

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
