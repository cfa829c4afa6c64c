"""What all exports print: their templates, and what the gain file says is proved."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from takagi.reports.code.controller_program import ControllerProgram

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

    Raises
    ------
    jinja2.UndefinedError : the template has a name that the context does not have.
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
