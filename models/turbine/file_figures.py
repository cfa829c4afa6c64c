"""One figure of a turbine file: found, its unit converted, its range checked.

Every function takes the document and the path of a field, ``"section.key"``, and raises
``ModelError`` with file, line and field.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any, NamedTuple

from takagi.models.errors import ModelError
from takagi.models.files.toml_document import Document
from takagi.models.files.turbine_units import accepted_units, to_si
from takagi.models.turbine.data import Figure


class FileFigure(NamedTuple):
    """Where a figure is in the file, which attribute it fills, and the range accepted in SI.

    The ranges are wide: they are there to catch a wrong unit, not an unusual turbine.
    """

    path: str
    attribute: str
    unit: str
    low: float
    high: float


def _entry(document: Document, path: str, example: str) -> Any:
    section, _, key = path.rpartition(".")
    content = document.data.get(section, {}) if section else document.data
    if key not in content:
        raise document.error(path, f"is missing; add {key} = {example} under [{section}]")
    return content[key]


def text_at(document: Document, path: str) -> str:
    """Return the text at a path; it must not be empty."""
    value = _entry(document, path, '"..."')
    if not isinstance(value, str) or not value.strip():
        raise document.error(path, f"{value!r} was given; text in quotes is needed")
    return value


def _table(document: Document, path: str, keys: Iterable[str], example: str) -> dict[str, Any]:
    """Return the inline table at a path, with exactly these keys."""
    entry = _entry(document, path, example)
    if not isinstance(entry, dict) or set(entry) != set(keys):
        raise document.error(path, f"{entry!r} was given; expected {example}")
    for key in keys:
        if key in ("unit", "source") and not (isinstance(entry[key], str) and entry[key].strip()):
            raise document.error(path, f"{key} is {entry[key]!r}; text in quotes is needed")
    return entry


def read_figure(document: Document, path: str, unit: str = "m") -> Figure:
    """Return ``{ value = ..., unit = "...", source = "..." }`` as the file has it."""
    example = f'{{ value = <number>, unit = "{unit}", source = "<where from>" }}'
    entry = _table(document, path, ("value", "unit", "source"), example)
    return Figure(_number(document, path, entry["value"]), entry["unit"], entry["source"])


def _number(document: Document, path: str, value: object) -> float:
    # bool is an int in Python, not in a turbine file
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise document.error(path, f"value {value!r} was given; a finite number is needed")
    return float(value)


def figure_at(document: Document, spec: FileFigure, figures: dict[str, Figure]) -> float:
    """Return a figure in SI and file it under its path."""
    found = read_figure(document, spec.path, accepted_units(spec.unit)[0])
    figures[spec.path] = found
    return _in_range(document, spec, found.value, found.unit)


def _in_range(document: Document, spec: FileFigure, value: float, unit: str) -> float:
    try:
        converted = to_si(value, unit, spec.unit)
    except ModelError as error:
        raise document.error(spec.path, str(error)) from error
    if not spec.low <= converted <= spec.high:
        raise document.error(
            spec.path,
            f"{value:.9g} {unit} = {converted:.9g} {spec.unit} was given; expected "
            f"{spec.low:.9g} to {spec.high:.9g} {spec.unit}; check value and unit",
        )
    return converted


def column_at(document: Document, spec: FileFigure) -> tuple[float, ...]:
    """Return a list ``{ unit = "...", values = [...] }`` in SI, at least two numbers."""
    example = f'{{ unit = "{accepted_units(spec.unit)[0]}", values = [<numbers>] }}'
    entry = _table(document, spec.path, ("unit", "values"), example)
    if not isinstance(entry["values"], list) or len(entry["values"]) < 2:
        raise document.error(spec.path, "values must be a list of at least 2 numbers")
    numbers = [_number(document, spec.path, value) for value in entry["values"]]
    return tuple(_in_range(document, spec, number, entry["unit"]) for number in numbers)
