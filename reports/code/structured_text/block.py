"""The target `st`: a function block in Structured Text (IEC 61131-3), and a README.

The block stores its kept values and its last outputs, and reads each input once in a cycle.  An
input that is not a number, or larger than any measurement, is replaced by its last good value;
before the first good value by one of the gain file.  If a result is not a number, kept values and
outputs do not change.  ``status`` says which of these cases occurred.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from typing import Any

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Constant,
    ControllerProgram,
    Spline,
    file_word,
    identifiers,
)
from takagi.reports.code.sampling import (
    BIT,
    REPORTED,
    longest_sample,
    reported_range,
    start_sample_time,
    status_bits,
)
from takagi.reports.code.structured_text.statements import RESERVED, Statements, real, told
from takagi.reports.code.target_text import as_list, filled, proof_lines
from takagi.reports.code.targets import Exported, ExportSettings

LARGEST = "1.0E30"  # no measurement in SI units is larger
# Largest number of entries of an array that small controllers accept (64 KiB of LREAL).
LARGEST_ARRAY = 8192


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the function block and a README.

    Raises ModelError: single precision, or a law that Structured Text cannot express.
    """
    if settings.precision != "double":
        raise ModelError("--to st computes in LREAL; leave --precision out, or take --to c")
    context = _context(program, settings)
    file, block = context["file"], context["block"]
    return Exported(
        {
            f"{file}.st": filled("structured_text", "block.st", context),
            "README.md": filled("structured_text", "README.md", context),
        },
        {
            f"{file}.st": f"function block {block}: import it, call it every sample",
            "README.md": "inputs, outputs, units and status",
        },
    )


def function_block(program: ControllerProgram, settings: ExportSettings) -> str:
    """Return the text of the function block."""
    return filled("structured_text", "block.st", _context(program, settings))


def _context(program: ControllerProgram, settings: ExportSettings) -> dict[str, Any]:
    """Return what the templates are filled with."""
    for constant in program.constants:
        _require_room(constant)
    word, inside = _words(program)
    file = file_word(program.plant)
    return {
        "program": program,
        "file": file,
        "block": f"FB_{file.upper()}",
        "time": start_sample_time(program, settings.sample_time),
        "zero": Decimal(0),
        "word": word,
        "inside": inside,
        "proof": proof_lines(program),
        "status": status_bits(program, REPORTED),
        "BIT": BIT,
        "LARGEST": LARGEST,
        "longest": longest_sample(program),
        "constants": [line for constant in program.constants for line in _constant(constant, word)],
        "statements": _statements(program, word, inside),
        "told": told,
        "note": lambda entry: _told(entry.unit, getattr(entry, "words", entry.meaning)),
        "real": real,
        "reported_range": reported_range,
        "as_list": as_list,
    }


def _words(program: ControllerProgram) -> tuple[dict[str, str], dict[str, str]]:
    """Return the identifier of each name, and the one that formulas use."""
    inputs, outputs = program.inputs, program.outputs
    names = [signal.name for signal in (*inputs, *outputs)]
    rest = [name for name in program.names() if name not in names]
    splines = [
        f"{constant.name} t{k}"
        for constant in program.constants
        if isinstance(constant.value, Spline)
        for k in range(1, len(constant.value.knots) + 1)
    ]
    added = [f"{signal.name} seen" for signal in inputs]
    added += [f"{signal.name} now" for signal in outputs]
    added += [f"{state.name} after" for state in program.kept]
    helpers = {f"{word}_{k}" for word in ("dl", "dr", *"khmxb") for k in range(1, 100)}
    word = identifiers(
        [*names, *rest, *added, "step time", *splines],
        RESERVED | helpers | {"i", "j", "part", "saved"},
        language="Structured Text",
        ignore_case=True,
    )
    inside = {signal.name: word[f"{signal.name} seen"] for signal in inputs}
    inside |= {signal.name: word[f"{signal.name} now"] for signal in outputs}
    inside |= {name: word[name] for name in (*rest, *splines)}
    return word, inside | {"sample_time": word["step time"]}


def _constant(constant: Constant, words: Mapping[str, str]) -> Iterator[str]:
    word, value = words[constant.name], constant.value
    # In a path such as K.*.0 some tools would read the end of a comment.
    note = f"(* {told(constant.unit)}; {constant.path.replace('*', 'i')} *)"
    if isinstance(value, Decimal):
        yield f"    {word} : LREAL := {real(value)}; {note}"
    elif isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            yield from _array(words[f"{constant.name} t{k}"], [knots], "LREAL", note)
        yield from _array(word, value.coefficients, "LREAL", note, flat=len(value.knots) == 1)
    elif isinstance(value[0], tuple):
        yield from _array(word, value, "INT", note, flat=False)
    else:
        yield from _array(word, [value], "LREAL", note)


def _statements(
    program: ControllerProgram, word: Mapping[str, str], inside: Mapping[str, str]
) -> Statements:
    """Return the steps of all stages, then the values that are kept until the next sample."""
    constants = {constant.name: constant for constant in program.constants}
    statements = Statements(constants, inside)
    for stage in program.stages:
        statements.say("")
        statements.say(f"(* {told(stage.name)} *)")
        if stage.kept:
            statements.start(stage.kept)
        for step in stage.assignments:
            statements.assign(step)
    statements.say("")
    statements.say("(* values that are kept until the next sample; all are updated together *)")
    for kept in program.kept:
        statements.say(f"{word[f'{kept.name} after']} := {statements.text(kept.next)};")
    return statements


def _array(
    word: str, rows: Iterable[Iterable[Decimal]], kind: str, note: str, *, flat: bool = True
) -> Iterator[str]:
    """Yield the declaration of an array, eight numbers in a line."""
    table = [list(row) for row in rows]
    numbers = [str(int(value)) if kind == "INT" else real(value) for row in table for value in row]
    size = f"0..{len(numbers) - 1}" if flat else f"0..{len(table) - 1}, 0..{len(table[0]) - 1}"
    yield f"    {word} : ARRAY[{size}] OF {kind} := [ {note}"
    for k in range(0, len(numbers), 8):
        tail = "" if k + 8 >= len(numbers) else ","
        yield "        " + ", ".join(numbers[k : k + 8]) + tail
    yield "    ];"


def _require_room(constant: Constant) -> None:
    value = constant.value
    rows = value.coefficients if isinstance(value, Spline) else value
    if isinstance(rows, tuple):
        count = sum(len(row) if isinstance(row, tuple) else 1 for row in rows)
        if count > LARGEST_ARRAY:
            raise ModelError(
                f"{constant.name} ({constant.path}) has {count} numbers; a function block holds "
                f"{LARGEST_ARRAY}: design with fewer rules (fewer premises, or product bounds), or "
                "write the law with --to c"
            )


def _told(unit: str, meaning: str) -> str:
    """Return unit and meaning as the text of a comment."""
    return told(f"{unit}: {meaning}".removesuffix(": "))
