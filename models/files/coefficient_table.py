"""Reader of coefficient tables: a comment header that says what it is, then a CSV grid."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.files.toml_document import read_text

FIRST_LINE = "takagi coefficient table 1"
ROWS = "tip-speed ratio [-]"
COLUMNS = {"collective pitch [deg]": np.pi / 180, "collective pitch [rad]": 1.0}
NEEDED = ("quantity", "rows", "columns", "source", "licence")


@dataclass(frozen=True, slots=True, eq=False)
class CoefficientTable:
    """values[i, j] at tip_speed_ratio[i] [-] and pitch[j] [rad]; header as the file gives it."""

    tip_speed_ratio: Floats
    pitch: Floats
    values: Floats
    header: dict[str, str]


def read_coefficient_table(path: Path) -> CoefficientTable:
    """Return a table from a file of this project's format.

    The file starts with ``# takagi coefficient table 1`` and ``# key: value`` lines (quantity,
    rows, columns, source, licence are needed), then a line with the pitch angles, then one line
    per tip-speed ratio.

    Raises
    ------
    ModelError : with file and line: header incomplete, a cell that is not a finite number, rows of
        different length, axes that do not increase, fewer than 4 points in a direction.
    """
    lines = list(enumerate(read_text(path).splitlines(), start=1))
    comments = [text[1:].strip() for _, text in lines if text.startswith("#")]
    if not comments or comments[0] != FIRST_LINE:
        raise ModelError(f"{path}:1: the first line must be '# {FIRST_LINE}'; add the header")
    header = {}
    for comment in comments[1:]:
        key, colon, value = comment.partition(":")
        if colon:
            header[key.strip()] = value.strip()
    _check_header(path, header)
    grid = [(number, text) for number, text in lines if text.strip() and text[0] != "#"]
    if len(grid) < 5:
        raise ModelError(f"{path}: {max(len(grid) - 1, 0)} rows of numbers; at least 4 are needed")
    pitch = _numbers(path, *grid[0], skip=1)
    rows = [_numbers(path, number, text) for number, text in grid[1:]]
    for (number, _), row in zip(grid[1:], rows, strict=True):
        if len(row) != len(pitch) + 1:
            raise ModelError(
                f"{path}:{number}: {len(row) - 1} values, but the first row names {len(pitch)} "
                "pitch angles; every row needs one value for each"
            )
    _check_increasing(path, grid[0][0], "pitch angle", pitch)
    for (number, _), row, after in zip(grid[2:], rows, rows[1:], strict=False):
        _check_increasing(path, number, "tip-speed ratio", [row[0], after[0]])
    if len(pitch) < 4 or rows[0][0] <= 0:
        raise ModelError(
            f"{path}:{grid[0][0]}: {len(pitch)} pitch angles and tip-speed ratios from {rows[0][0]}"
            "; at least 4 angles and ratios above 0 are needed"
        )
    values = np.array(rows)
    angles = np.array(pitch) * COLUMNS[header["columns"]]
    return CoefficientTable(values[:, 0], angles, values[:, 1:], header)


def _check_header(path: Path, header: dict[str, str]) -> None:
    for key in NEEDED:
        if not header.get(key):
            raise ModelError(f"{path}: header line '# {key}: ...' is missing; add it")
    if header["rows"] != ROWS or header["columns"] not in COLUMNS:
        raise ModelError(
            f"{path}: rows are {header['rows']!r} and columns {header['columns']!r}; expected rows "
            f"{ROWS!r} and columns {' or '.join(map(repr, COLUMNS))}"
        )


def _numbers(path: Path, line: int, text: str, skip: int = 0) -> list[float]:
    found = []
    for position, cell in enumerate(text.split(","), start=1):
        if position <= skip:
            continue
        try:
            value = float(cell)
        except ValueError:
            value = float("nan")
        if not isfinite(value):
            raise ModelError(
                f"{path}:{line}: column {position} is {cell.strip()!r}; a finite number is needed"
            )
        found.append(value)
    return found


def _check_increasing(path: Path, line: int, what: str, values: list[float]) -> None:
    for before, after in zip(values, values[1:], strict=False):
        if after <= before:
            raise ModelError(
                f"{path}:{line}: {what} {after:.9g} follows {before:.9g}; sort them increasing, "
                "each once"
            )
