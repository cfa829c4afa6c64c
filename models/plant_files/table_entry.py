"""A coefficient table that a plant file names: its path, and its function."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from takagi.models.errors import ModelError
from takagi.models.files.csv_table import read_curve, read_surface
from takagi.models.files.toml_document import Document
from takagi.models.files.units import Unit, parse_unit
from takagi.models.plant.entries import TableEntry
from takagi.models.splines.table_function import TableFunction, table_function


def read_table(document: Document, name: str, given: TableEntry) -> type[TableFunction]:
    """Return the function of one or two arguments, in SI.

    Raises
    ------
    ModelError : the path, a unit, or the table itself is wrong.
    """
    path = table_path(document, name, given.file)
    value = _unit(document, f"tables.{name}.unit", given.unit)
    place = f"tables.{name}.arguments"
    units = [_unit(document, place, argument.unit) for argument in given.arguments]
    names = [f"{a.name} [{unit.si}]" for a, unit in zip(given.arguments, units, strict=True)]
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
    place = f"tables.{name}.file"
    parts = PurePosixPath(file)
    if parts.is_absolute() or ".." in parts.parts or "\\" in file or ":" in file or not file:
        raise document.error(
            place,
            f"{file!r} was given; name a file in the folder of this one, or below it, with '/'",
        )
    folder = document.path.parent.resolve()
    path = (folder / parts).resolve()
    if not path.is_relative_to(folder):
        raise document.error(place, f"{file!r} leads out of the folder of this file; copy it there")
    if not path.is_file():
        raise document.error(place, f"{file!r} is not there; put the table beside this file")
    return document.path.parent / parts


def _unit(document: Document, place: str, text: str) -> Unit:
    try:
        return parse_unit(text)
    except ModelError as error:
        raise document.error(place, str(error)) from error
