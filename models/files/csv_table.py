"""Tables of one or two arguments from CSV, a turbine's tables of coefficients, and matrices.

One argument: lines ``x, value``.  Two arguments: the first line has an empty corner and then the
values of the second argument; each further line the value of the first argument and then one
number for each of the second.  Lines that start with ``#`` are comments.  Those of a coefficient
table say what it is.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.files.library import read_text
from takagi.models.files.units import Unit
from takagi.models.splines.spline import Curve, Surface, interpolate, interpolate_curve

MAX_CELLS = 200_000
SMALLEST_AXIS = 4  # points; what a cubic needs
FIT = 1e-6  # of the values' range: how near the spline passes to the table
Row = tuple[int, list[Fraction]]
FIRST_LINE = "takagi coefficient table 1"
ROWS = "tip-speed ratio [-]"
COLUMNS = {"collective pitch [deg]": np.pi / 180, "collective pitch [rad]": 1.0}
NEEDED = ("quantity", "rows", "columns", "source", "licence")


def read_curve(path: Path, *, name: str, units: tuple[Unit, Unit], x_name: str = "x") -> Curve:
    """Return the cubic spline through a table of two columns, in SI.

    ``units`` : of the argument and of the value, as the file has them.

    Raises
    ------
    ModelError : with file and line: a cell that is not a number, a row without two numbers, x
        that does not increase, fewer than 4 rows.
    """
    rows = _rows(path, skip_corner=False)
    for line, row in rows:
        if len(row) != 2:
            raise ModelError(f"{path}:{line}: {len(row)} numbers; x and value are needed, two")
    _check_axis(path, x_name, [(line, row[0]) for line, row in rows])
    x, values = (
        [float(unit.to_si(row[column])) for _, row in rows] for column, unit in enumerate(units)
    )
    curve = interpolate_curve(x, values, name=name, x_name=x_name)
    _check_fit(path, np.asarray(curve(x)), np.asarray(values))
    return curve


def read_surface(
    path: Path, *, name: str, units: tuple[Unit, Unit, Unit], axes: tuple[str, str] = ("x", "y")
) -> Surface:
    """Return the bicubic spline through a grid, in SI.

    ``units`` : of first argument (down), second argument (across) and value, as the file has them.

    Raises
    ------
    ModelError : as ``read_curve`` does, and for rows of different length, or numbers so small that
        12 decimals do not hold them.
    """
    down, across, cells = _grid(path, axes)
    x = [float(units[0].to_si(value)) for value in down]
    y = [float(units[1].to_si(value)) for value in across]
    values = np.array([[float(units[2].to_si(value)) for value in row] for row in cells])
    surface = interpolate(x, y, values, name=name, x_name=axes[0], y_name=axes[1])
    spline_values = surface(np.array(x)[:, None], np.array(y)[None, :], clip=True)
    _check_fit(path, np.asarray(spline_values), values)
    return surface


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
    comments = [line[1:].strip() for line in read_text(path).splitlines() if line.startswith("#")]
    if not comments or comments[0] != FIRST_LINE:
        raise ModelError(f"{path}:1: the first line must be '# {FIRST_LINE}'; add the header")
    pairs = (comment.partition(":") for comment in comments[1:])
    header = {key.strip(): value.strip() for key, colon, value in pairs if colon}
    _check_header(path, header)
    ratios, angles, values = (
        np.array(axis, dtype=np.float64) for axis in _grid(path, ("tip-speed ratio", "pitch angle"))
    )
    if ratios[0] <= 0:
        raise ModelError(
            f"{path}: tip-speed ratios from {ratios[0]:.9g} were given; ratios above 0 are needed"
        )
    return CoefficientTable(ratios, angles * COLUMNS[header["columns"]], values, header)


def _check_header(path: Path, header: dict[str, str]) -> None:
    for key in NEEDED:
        if not header.get(key):
            raise ModelError(f"{path}: header line '# {key}: ...' is missing; add it")
    if header["rows"] != ROWS or header["columns"] not in COLUMNS:
        raise ModelError(
            f"{path}: rows are {header['rows']!r} and columns {header['columns']!r}; expected rows "
            f"{ROWS!r} and columns {' or '.join(map(repr, COLUMNS))}"
        )


def _grid(
    path: Path, axes: tuple[str, str]
) -> tuple[list[Fraction], list[Fraction], list[list[Fraction]]]:
    """Return the arguments down and across, and one row of values for each of the first."""
    (top, across), *down = _rows(path, skip_corner=True)
    for line, row in down:
        if len(row) != len(across) + 1:
            raise ModelError(
                f"{path}:{line}: {len(row) - 1} values, but line {top} names {len(across)} of "
                f"{axes[1]}; every row needs one for each"
            )
    _check_axis(path, axes[0], [(line, row[0]) for line, row in down])
    _check_axis(path, axes[1], [(top, value) for value in across])
    return [row[0] for _, row in down], across, [row[1:] for _, row in down]


def _rows(path: Path, *, skip_corner: bool) -> list[Row]:
    """Return (line number, numbers) of every line that is not a comment."""
    rows: list[Row] = []
    cells_read = 0
    for line, text in enumerate(read_text(path).splitlines(), start=1):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        cells = text.split(",")
        cells_read += len(cells)
        if cells_read > MAX_CELLS:
            raise ModelError(f"{path}:{line}: more than {MAX_CELLS} cells; thin the table out")
        skip = 1 if skip_corner and not rows else 0
        numbers = [_number(path, line, at, cell) for at, cell in enumerate(cells[skip:], 1 + skip)]
        rows.append((line, numbers))
    needed = SMALLEST_AXIS + (1 if skip_corner else 0)
    if len(rows) < needed:
        raise ModelError(
            f"{path}: {len(rows)} lines of numbers; a cubic spline needs at least {needed}"
        )
    return rows


def read_matrix(path: Path) -> Floats:
    """Return a matrix: a row a line, its numbers between commas, semicolons or spaces.

    Raises
    ------
    ModelError : with file and line: no row, a cell that is not a number, rows of different length.
    """
    rows: list[list[float]] = []
    for line, text in enumerate(read_text(path).splitlines(), start=1):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        cells = re.split(r"\s*[,;]\s*" if re.search("[,;]", text) else r"\s+", text.strip())
        if cells[-1] == "":
            cells.pop()  # a separator behind the last number
        row = [float(_number(path, line, at, cell)) for at, cell in enumerate(cells, start=1)]
        if rows and len(row) != len(rows[0]):
            raise ModelError(
                f"{path}:{line}: {len(row)} numbers, and {len(rows[0])} in the rows above; as many "
                "are needed in each row of a matrix"
            )
        rows.append(row)
    if not rows:
        raise ModelError(f"{path}: has no numbers; a matrix, one row a line, is needed")
    return np.array(rows)


def _number(path: Path, line: int, column: int, cell: str) -> Fraction:
    try:
        value = Decimal(cell.strip())
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or abs(value.adjusted()) > 100 or len(cell) > 60:
        raise ModelError(
            f"{path}:{line}: column {column} is {cell.strip()[:40]!r}; a finite number is needed "
            "(lines with words start with '#')"
        )
    return Fraction(value)


def _check_axis(path: Path, axis_name: str, values: list[tuple[int, Fraction]]) -> None:
    if len(values) < SMALLEST_AXIS:
        raise ModelError(
            f"{path}:{values[0][0]}: {len(values)} values of {axis_name}; a cubic spline needs at "
            f"least {SMALLEST_AXIS}"
        )
    for (_, previous), (line, value) in zip(values, values[1:], strict=False):
        if value <= previous:
            raise ModelError(
                f"{path}:{line}: {axis_name} {float(value):.9g} follows {float(previous):.9g}; "
                "sort them increasing, each once"
            )


def _check_fit(path: Path, spline_values: np.ndarray, values: np.ndarray) -> None:
    """Refuse a spline that misses its table: its decimals are too few for the numbers."""
    size = float(np.ptp(values) or np.max(np.abs(values)))
    worst = float(np.max(np.abs(spline_values - values)))
    if worst > FIT * size:
        raise ModelError(
            f"{path}: the spline misses the table by {worst:.3g}, values span {size:.3g}; the "
            "points lie too close or the values are too small in SI: scale them, and multiply in "
            "the expression"
        )
