"""Compares a table of a certificate with the CSV file that it is said to come from.

The knots must be those of the not-a-knot spline through the file's points: all points except the
second and the last but one. There are then as many coefficients as points, and the values at the
points determine them. Numbers of a file are decimals in its own units, so both are compared up to a
small relative error.

Numbers of plant files in SI: an independent reading of the closed list of units.

Names with spaces or ``*`` between them, powers with ``^``, one ``/``.  For units with pi (deg, rpm)
the value in SI is the nearest decimal with 12 places, and with ten digits at least, as the page on
plant files says; with a root that is no fraction (bar^0.5) the nearest one with 15 digits.
"""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from math import lcm, prod
from pathlib import Path

from takagi.certificates.checker.files.model_content import OtherModel, file_content
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.table import Table

LARGEST_FILE, MOST_CELLS, LONGEST_CELL, MOST_EXPONENT = 16_000_000, 200_000, 60, 100
TABLE_TOLERANCE = Fraction(1, 10**6)  # of the range of the values; of a direction's length
END = 3  # knots that are repeated at an end, besides the first and the last


def compare_table(path: Path, table: Table, units: list[str]) -> None:
    """Compare knots and values with those of a file.

    Parameters
    ----------
    units : of each argument, then of the value, as the plant's file has them.

    Raises
    ------
    CertificateError : the file is no such table, or is too large.
    OtherModel : it has other points or values.
    Refused : a unit that is not known.
    """
    rows = _rows(path, corner=table.arguments == 2)
    if len(units) != table.arguments + 1 or len(rows) < 2:
        raise CertificateError(f"{path}: no table of {table.arguments} argument(s)")
    across = [in_si(y, units[1]) for y in rows[0]] if table.arguments == 2 else []
    down = rows[1:] if across else rows
    if any(len(row) != (len(across) or 1) + 1 for row in down):
        raise CertificateError(f"{path}: rows of different length")
    axes = [[in_si(row[0], units[0]) for row in down], *([across] if across else [])]
    for points, knots in zip(axes, table.knots, strict=True):
        expected = [points[0]] * END + [points[0], *points[2:-2], points[-1]] + [points[-1]] * END
        slack = TABLE_TOLERANCE * abs(points[-1] - points[0])
        if len(knots) != len(expected) or any(
            abs(a - b) > slack for a, b in zip(knots, expected, strict=True)
        ):
            raise OtherModel(f"{path}: its points are not those of the certificate's table")
    values = [[in_si(value, units[-1]) for value in row[1:]] for row in down]
    every = [value for row in values for value in row]
    slack = TABLE_TOLERANCE * ((max(every) - min(every)) or abs(every[0]))
    for x, row in zip(axes[0], values, strict=True):
        for y, value in zip(across or [Fraction(0)], row, strict=True):
            point = [x, y][: table.arguments]
            inside = [
                min(max(p, low), high) for p, (low, high) in zip(point, table.sides, strict=True)
            ]
            table_value = table.exact(inside, (0,) * table.arguments)
            if table_value is None or abs(table_value - value) > slack:
                at_point = ", ".join(f"{float(p):.6g}" for p in point)
                table_figure = "none" if table_value is None else f"{float(table_value):.9g}"
                raise OtherModel(
                    f"{path}: its value at {at_point} is {float(value):.9g} there, {table_figure} "
                    "in the certificate"
                )


def _rows(path: Path, *, corner: bool) -> list[list[Fraction]]:
    try:
        written = file_content(path, what="table", largest=LARGEST_FILE).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CertificateError(f"{path}: cannot be read: {error}") from error
    rows: list[list[Fraction]] = []
    cells = 0
    for line in written.splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            line_cells = line.split(",")
            cells += len(line_cells)
            if cells > MOST_CELLS:
                raise CertificateError(f"{path}: more than {MOST_CELLS} cells")
            rows.append([_number(path, p) for p in line_cells[1 if corner and not rows else 0 :]])
    return rows


def _number(path: Path, cell: str) -> Fraction:
    try:
        value = Decimal(cell.strip())
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or abs(value.adjusted()) > MOST_EXPONENT or len(cell) > LONGEST_CELL:
        raise CertificateError(f"{path}: {cell[:40]!a} is no number")
    return Fraction(value)


PI = Fraction("3.14159265358979323846264338327950288419716939937510")
FEWEST_DECIMALS, PI_DIGITS = 12, 10
COHERENT = frozenset("kg m s A K mol cd rad N Pa J W C V Ohm S F Wb H T".split())
# Factor to coherent units, and the power of pi in it.
OTHER_UNITS = {
    "g": (Fraction(1, 1000), 0),
    "t": (Fraction(1000), 0),
    "L": (Fraction(1, 1000), 0),
    "bar": (Fraction(100000), 0),
    "min": (Fraction(60), 0),
    "h": (Fraction(3600), 0),
    "deg": (Fraction(1, 180), 1),
    "rpm": (Fraction(1, 30), 1),
    "%": (Fraction(1, 100), 0),
}
PREFIXES = {"G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "n": -9}
PREFIXED = (COHERENT - {"kg", "cd"}) | {"g", "L", "bar"}
FACTOR = re.compile(
    r"([A-Za-z%]+)(?:(?:\^|\*\*)(?:(-?[0-9]{1,2}(?:\.[0-9]{1,3})?)|<(-?[0-9]{1,2}):([1-9][0-9]?)>))?",
    re.ASCII,
)
SHARE = re.compile(r"\((-?[0-9]{1,2})/([1-9][0-9]?)\)", re.ASCII)
ROOT_DIGITS, MOST_DEGREE = 15, 1000


def in_si(value: Fraction, unit: str) -> Fraction:
    """Return the value in SI.

    Raises
    ------
    Refused : a unit that is not in the list, or a text of another form.
    """
    if unit.strip() == "-":
        return value
    written = SHARE.sub(r"<\1:\2>", unit.strip())
    above, slash, below = (product_text.strip() for product_text in written.partition("/"))
    if not above or (slash and not below) or (above == "1" and not slash):
        raise Refused(f"the unit {unit[:40]!a} cannot be read")
    if below.startswith("(") and below.endswith(")"):
        below = below[1:-1]
    factors: list[tuple[Fraction, Fraction]] = []
    turns = Fraction(0)
    for product_text, sign in (("" if above == "1" else above, 1), (below, -1)):
        for word in re.sub(r"(?<!\*)\*(?!\*)", " ", product_text).split():
            match = FACTOR.fullmatch(word)
            if match is None:
                raise Refused(f"the unit {unit[:40]!a} cannot be read")
            scale, power_of_pi = _meaning(match.group(1), unit)
            power = sign * Fraction(match.group(2) or match.group(3) or 1)
            power /= int(match.group(4) or 1)
            factors.append((scale, power))
            turns += power_of_pi * power
    degree = lcm(*(power.denominator for _, power in factors))
    if turns.denominator > 1 or degree > MOST_DEGREE:
        raise Refused(f"the unit {unit[:40]!a} cannot be read")
    radicand = prod((scale ** int(power * degree) for scale, power in factors), start=Fraction(1))
    if turns:
        converted = value * _root(radicand, degree) * PI ** int(turns)
        size, decimals = abs(converted) * 10**FEWEST_DECIMALS, FEWEST_DECIMALS
        while size and size < 10 ** (PI_DIGITS - 1):
            size, decimals = size * 10, decimals + 1
        return round(converted, decimals)
    factor = _root(radicand, degree)
    if factor**degree == radicand:
        return value * factor
    converted, size = value * factor, 0
    while abs(converted) >= 10 ** (size + 1):
        size += 1
    while converted and abs(converted) < Fraction(10) ** size:
        size -= 1
    return round(converted, ROOT_DIGITS - 1 - size)


def _root(value: Fraction, degree: int) -> Fraction:
    """Return the root of a number > 0: exact if it is a fraction, else to 40 digits or more."""
    if degree == 1:
        return value
    top, bottom = (_whole_root(integer, degree) for integer in value.as_integer_ratio())
    if top**degree == value.numerator and bottom**degree == value.denominator:
        return Fraction(top, bottom)
    precision = 10**40 * value.denominator
    scaled_root = _whole_root(int(value * precision**degree), degree)
    return Fraction(scaled_root, precision)


def _whole_root(value: int, degree: int) -> int:
    """Return the largest whole number whose power is not above the value, by bisection."""
    low, high = 0, 1 << (value.bit_length() // degree + 1)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if middle**degree <= value else (low, middle)
    return low


def _meaning(name: str, unit: str) -> tuple[Fraction, int]:
    if name in COHERENT:
        return Fraction(1), 0
    if name in OTHER_UNITS:
        return OTHER_UNITS[name]
    if name[:1] in PREFIXES and name[1:] in PREFIXED:
        scale, turns = _meaning(name[1:], unit)
        return scale * Fraction(10) ** PREFIXES[name[0]], turns
    raise Refused(f"the unit {unit[:40]!a} is not known")
