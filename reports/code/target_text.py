"""What exports print: templates, what the gain file says is proved, and a law's numbers as CSV."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from decimal import Decimal
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from takagi.reports.code.controller_program import Constant, ControllerProgram, Spline
from takagi.reports.code.targets import Exported, ExportSettings
from takagi.reports.output import csv_text

if TYPE_CHECKING:
    from jinja2 import Environment


def proof_lines(program: ControllerProgram) -> tuple[str, ...]:
    """Return one sentence a line: verdict, in which time, in which ranges, and each claim's name.

    The gain file's word; nothing is checked here, and the first line says how to check it.
    """
    if not program.hashes:
        return (f"Proved: nothing; {program.verdict}.",)
    sampled = program.sample_time
    time = (
        "in exact arithmetic and continuous time; the samples of this code are covered only by a "
        "claim that names a sample time"
        if sampled is None
        else f"in exact arithmetic and discrete time, with a sample every {sampled} s and no other"
    )
    claims = program.document["certificate"].get("claims", ())
    return (
        f"The gain file says {program.verdict}. Confirm it with: takagi check CERTIFICATE --gains "
        "GAINS",
        f"What is proved holds {time}.",
        f"What is proved holds in these ranges: {', '.join(_ranges(program)) or 'all values'}.",
        *(f"Claim {k}, {claim['verdict']}: {claim['name']}" for k, claim in enumerate(claims, 1)),
    )


def as_list(lines: Iterable[str]) -> str:
    """Return the lines as a list of Markdown."""
    return "\n".join(f"- {line}" for line in lines)


def _ranges(program: ControllerProgram) -> Iterator[str]:
    document = program.document
    if program.kind == "turbine":
        winds = [float(wind) for wind in document["trim"]["wind"]]
        yield f"wind {min(winds):g} to {max(winds):g} m/s, and what each claim assumes of the wind"
        return
    signals: list[Mapping[str, Any]] = [*document.get("states", ()), *document.get("inputs", ())]
    for signal in signals:
        if signal.get("range") is not None:
            low, high = (f"{float(end):.6g}" for end in signal["range"])
            yield f"{signal['name']} {low} to {high} {signal['unit']}"


def filled(room: str, name: str, context: Mapping[str, Any]) -> str:
    """Return ``name.jinja`` of a folder below ``reports/code``, filled; nothing is escaped.

    Raises jinja2.UndefinedError : the template has a name that the context does not have.
    """
    return _environment(room).get_template(f"{name}.jinja").render(context)


@cache
def _environment(room: str) -> Environment:
    # Imported here: most verbs write no code.
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = files(f"takagi.reports.code.{room}")
    return Environment(
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
    )


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
