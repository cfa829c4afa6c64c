"""The numbers of a law as CSV: one file for all single numbers, one for each row of nodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal

from takagi.reports.code.controller_program import Constant, ControllerProgram, Spline
from takagi.reports.code.targets import Exported, ExportSettings
from takagi.reports.output import csv_text


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the tables: ``numbers.csv``, and one file for each row, matrix or spline.

    The first line has the names with their units; numbers are the gain file's decimals.
    """
    single = [constant for constant in program.constants if isinstance(constant.value, Decimal)]
    files = {
        "numbers.csv": csv_text(
            ("name", "value", "unit", "place in gains.json"),
            (
                (constant.name, str(constant.value), constant.unit, constant.path)
                for constant in single
            ),
        )
    }
    use = {"numbers.csv": f"{len(single)} single numbers with units"}
    for constant in program.constants:
        for name, text, what in _tables(constant):
            files[name], use[name] = text, what
    return Exported(files, use)


def _tables(constant: Constant) -> Iterable[tuple[str, str, str]]:
    """Yield file name, text and description for each table of a constant."""
    value, name = constant.value, constant.name
    if isinstance(value, Decimal):
        return
    if isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            text = csv_text((f"knots of argument {k}",), ((str(knot),) for knot in knots))
            yield f"{name}_knots_{k}.csv", text, f"knots of the cubic spline {name}"
        yield _matrix(name, f"coefficients of {name} [{constant.unit}]", value.coefficients)
    elif isinstance(value[0], tuple):
        yield _matrix(name, f"{name} [{constant.unit}]", value)
    else:
        text = csv_text((f"{name} [{constant.unit}]",), ((str(number),) for number in value))
        yield f"{name}.csv", text, f"{len(value)} numbers, {constant.path} of the gain file"


def _matrix(name: str, title: str, rows: Sequence[Sequence[Decimal]]) -> tuple[str, str, str]:
    head = (f"{title}, column 0", *(f"column {k}" for k in range(1, len(rows[0]))))
    text = csv_text(head, (tuple(map(str, row)) for row in rows))
    return f"{name}.csv", text, f"{len(rows)} rows of {len(rows[0])}: {title}"
