"""Tables of one or two arguments from CSV.

One argument: lines ``x, value``.  Two arguments: the first line has an empty corner and then the
values of the second argument; each further line the value of the first argument and then one
number for each of the second.  Lines that start with ``#`` are comments.
"""

from __future__ import annotations

from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.files.toml_document import read_text
from takagi.models.files.units import Unit
from takagi.models.splines.curve import Curve, interpolate_curve
from takagi.models.splines.surface import Surface, interpolate

MAX_CELLS = 200_000
SMALLEST_AXIS = 4  # points; what a cubic needs
FIT = 1e-6  # of the largest value: how near the spline passes to the table
Row = tuple[int, list[Fraction]]


def read_curve(path: Path, *, name: str, units: tuple[Unit, Unit], x_name: str = "x") -> Curve:
    """Return the cubic spline through a table of two columns, in SI.

    Parameters
    ----------
    units : of the argument and of the value, as the file has them.

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

    Parameters
    ----------
    units : of first argument (down), second argument (across) and value, as the file has them.

    Raises
    ------
    ModelError : as ``read_curve`` does, and for rows of different length, or numbers so small that
        12 decimals do not hold them.
    """
    rows = _rows(path, skip_corner=True)
    (top, across), down = rows[0], rows[1:]
    for line, row in down:
        if len(row) != len(across) + 1:
            raise ModelError(
                f"{path}:{line}: {len(row) - 1} values, but line {top} names {len(across)} of "
                f"{axes[1]}; every row needs one for each"
            )
    _check_axis(path, axes[0], [(line, row[0]) for line, row in down])
    _check_axis(path, axes[1], [(top, value) for value in across])
    x = [float(units[0].to_si(row[0])) for _, row in down]
    y = [float(units[1].to_si(value)) for value in across]
    values = np.array([[float(units[2].to_si(v)) for v in row[1:]] for _, row in down])
    surface = interpolate(x, y, values, name=name, x_name=axes[0], y_name=axes[1])
    found = surface(np.array(x)[:, None], np.array(y)[None, :], clip=True)
    _check_fit(path, np.asarray(found), values)
    return surface


def _rows(path: Path, *, skip_corner: bool) -> list[Row]:
    """Return (line number, numbers) of every line that is not a comment."""
    found: list[Row] = []
    cells_read = 0
    for line, text in enumerate(read_text(path).splitlines(), start=1):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        cells = text.split(",")
        cells_read += len(cells)
        if cells_read > MAX_CELLS:
            raise ModelError(f"{path}:{line}: more than {MAX_CELLS} cells; thin the table out")
        skip = 1 if skip_corner and not found else 0
        numbers = [_number(path, line, at, cell) for at, cell in enumerate(cells[skip:], 1 + skip)]
        found.append((line, numbers))
    needed = SMALLEST_AXIS + (1 if skip_corner else 0)
    if len(found) < needed:
        raise ModelError(
            f"{path}: {len(found)} lines of numbers; a cubic spline needs at least {needed}"
        )
    return found


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


def _check_axis(path: Path, what: str, values: list[tuple[int, Fraction]]) -> None:
    if len(values) < SMALLEST_AXIS:
        raise ModelError(
            f"{path}:{values[0][0]}: {len(values)} values of {what}; a cubic spline needs at least "
            f"{SMALLEST_AXIS}"
        )
    for (_, before), (line, after) in zip(values, values[1:], strict=False):
        if after <= before:
            raise ModelError(
                f"{path}:{line}: {what} {float(after):.9g} follows {float(before):.9g}; sort them "
                "increasing, each once"
            )


def _check_fit(path: Path, found: np.ndarray, values: np.ndarray) -> None:
    """Refuse a spline that misses its table: its decimals are too few for the numbers."""
    size = float(np.max(np.abs(values)))
    worst = float(np.max(np.abs(found - values)))
    if worst > FIT * size:
        raise ModelError(
            f"{path}: the spline misses the table by {worst:.3g}, values reach {size:.3g}; the "
            "points lie too close or the values are too small in SI: scale them, and multiply in "
            "the expression"
        )
