"""The target `st`: a function block in Structured Text (IEC 61131-3), and a README.

The block stores its kept values and its last outputs, and reads each input once in a cycle.  An
input that is not a number, or larger than any measurement, is replaced by its last good value;
before the first good value by one of the gain file.  If a result is not a number, kept values and
outputs do not change.  ``status`` says which of these cases occurred.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from decimal import Decimal

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Constant,
    ControllerProgram,
    Spline,
    file_word,
    identifiers,
)
from takagi.reports.code.proof_words import as_list, proof_lines
from takagi.reports.code.sampling import longest_sample, start_sample_time
from takagi.reports.code.status import BIT, REPORTED, reported_range, status_bits
from takagi.reports.code.structured_text.statements import RESERVED, Statements, real, told
from takagi.reports.code.targets import Exported, ExportSettings

LARGEST = "1.0E30"  # no measurement in SI units is larger
# Largest number of entries of an array that small controllers accept (64 KiB of LREAL).
LARGEST_ARRAY = 8192


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the function block and a README.

    Raises
    ------
    ModelError : single precision, or a law that Structured Text cannot express.
    """
    if settings.precision != "double":
        raise ModelError("--to st computes in LREAL; leave --precision out, or take --to c")
    word = file_word(program.plant)
    block = f"FB_{word.upper()}"
    return Exported(
        {f"{word}.st": function_block(program, settings), "README.md": _page(program, word)},
        {
            f"{word}.st": f"function block {block}: import it, call it every sample",
            "README.md": "inputs, outputs, units and status",
        },
    )


def function_block(program: ControllerProgram, settings: ExportSettings) -> str:
    """Return the text of the function block."""
    for constant in program.constants:
        _require_room(constant)
    return "\n".join(_Block(program, settings).lines()) + "\n"


class _Block:
    def __init__(self, program: ControllerProgram, settings: ExportSettings) -> None:
        self.program = program
        self.time = start_sample_time(program, settings.sample_time)
        self.status = sorted(status_bits(program, REPORTED))
        inputs, outputs = program.inputs, program.outputs
        names = [one.name for one in (*inputs, *outputs)]
        own = [f"{signal.name} seen" for signal in inputs] + [
            f"{signal.name} now" for signal in outputs
        ]
        own += [f"{state.name} after" for state in program.kept] + ["step time"]
        rest = [name for name in program.names() if name not in names]
        splines = [
            f"{constant.name} t{k}"
            for constant in program.constants
            if isinstance(constant.value, Spline)
            for k in range(1, len(constant.value.knots) + 1)
        ]
        helpers = {f"{word}_{k}" for word in "khmxb" for k in range(1, 100)}
        helpers |= {f"{word}_{k}" for word in ("dl", "dr") for k in range(1, 100)}
        self.word = identifiers(
            [*names, *rest, *own, *splines],
            RESERVED | helpers | {"i", "j", "part", "saved"},
            language="Structured Text",
            ignore_case=True,
        )
        inside = {signal.name: self.word[f"{signal.name} seen"] for signal in inputs}
        inside |= {signal.name: self.word[f"{signal.name} now"] for signal in outputs}
        inside |= {name: self.word[name] for name in (*rest, *splines)}
        self.inside = inside | {"sample_time": self.word["step time"]}

    def lines(self) -> Iterator[str]:
        body = self._body()
        program = self.program
        yield f"(* {_told(program.name, '')}: the law of its gain file, IEC 61131-3."
        for line in proof_lines(program):
            yield f"   {told(line)}"
        yield f"   Gains {told(program.hashes.get('gains', '-'))}"
        yield "   Numbers are those of the gain file. SI units, angles in rad. *)"
        yield f"FUNCTION_BLOCK FB_{file_word(program.plant).upper()}"
        yield "VAR_INPUT"
        for signal in program.inputs:
            comment = _told(signal.unit, signal.meaning)
            yield f"    {self.word[signal.name]} : LREAL; (* {comment} *)"
        yield f"    sample_time : LREAL := {real(self.time)}; (* s: from one call to the next *)"
        yield "    reset : BOOL; (* TRUE starts again from the next inputs *)"
        yield "END_VAR"
        yield "VAR_OUTPUT"
        for signal in program.outputs:
            comment = _told(signal.unit, signal.meaning)
            yield f"    {self.word[signal.name]} : LREAL; (* {comment} *)"
        yield "    status : UINT; (* 0, or a sum of these:"
        for number, _, text in self.status:
            yield f"        {number}  {text}"
        yield "    *)"
        yield "END_VAR"
        yield "VAR CONSTANT"
        for constant in program.constants:
            yield from self._constant(constant)
        yield "END_VAR"
        yield "VAR"
        yield "    started : BOOL := FALSE;"
        yield "    ready : BOOL;"
        for state in program.kept:
            note = _told(state.unit, state.meaning)
            yield f"    {self.word[state.name]} : LREAL; (* {note} *)"
            yield f"    {self.word[f'{state.name} after']} : LREAL;"
        for signal in program.inputs:
            yield f"    {self.inside[signal.name]} : LREAL := {real(signal.rest or Decimal(0))};"
        for signal in program.outputs:
            yield f"    {self.inside[signal.name]} : LREAL;"
        yield f"    {self.inside['sample_time']} : LREAL := {real(self.time)};"
        for stage in program.stages:
            for step in stage.steps:
                yield f"    {self.word[step.name]} : LREAL; (* {_told(step.unit, '')} *)"
        yield from self._helpers(body)
        yield "END_VAR"
        yield ""
        yield from body.lines
        yield "END_FUNCTION_BLOCK"

    @staticmethod
    def _helpers(body: Statements) -> Iterator[str]:
        for name in body.indices:
            yield f"    {name} : INT;"
        for name, last in body.arrays.items():
            yield f"    {name} : ARRAY[0..{last}] OF LREAL;"
        yield "    i : INT;"
        yield "    j : INT;"
        yield "    part : LREAL;"
        yield "    saved : LREAL;"

    def _constant(self, constant: Constant) -> Iterator[str]:
        word, value = self.word[constant.name], constant.value
        # In a path such as K.*.0 some tools would read the end of a comment.
        note = f"(* {_told(constant.unit, '')}; {constant.place.replace('*', 'i')} *)"
        if isinstance(value, Decimal):
            yield f"    {word} : LREAL := {real(value)}; {note}"
        elif isinstance(value, Spline):
            for k, knots in enumerate(value.knots, start=1):
                yield from _array(self.word[f"{constant.name} t{k}"], [knots], "LREAL", note)
            rows = value.coefficients
            yield from _array(word, rows, "LREAL", note, flat=len(value.knots) == 1)
        elif isinstance(value[0], tuple):
            yield from _array(word, value, "INT", note, flat=False)
        else:
            yield from _array(word, [value], "LREAL", note)

    def _body(self) -> Statements:
        program = self.program
        statements = Statements(
            {constant.name: constant for constant in program.constants}, self.inside
        )
        statements.indent = ""
        say = statements.say
        say("status := 0;")
        say("IF reset THEN started := FALSE; END_IF;")
        self._read(statements)
        for stage in program.stages:
            say("")
            say(f"(* {told(stage.name)} *)")
            if stage.kept:
                self._start(statements, stage.kept)
            for step in stage.assignments:
                statements.assign(step)
        say("")
        say("(* values that are kept until the next sample; all are updated together *)")
        for kept in program.kept:
            say(f"{self.word[f'{kept.name} after']} := {statements.text(kept.next)};")
        results = [self.inside[signal.name] for signal in program.outputs]
        results += [self.word[f"{state.name} after"] for state in program.kept]
        say("ready := TRUE;")
        for name in results:
            say(f"IF NOT (ABS({name}) <= {LARGEST}) THEN ready := FALSE; END_IF;")
        say("IF ready THEN")
        for signal in program.outputs:
            say(f"    {self.word[signal.name]} := {self.inside[signal.name]};")
        for kept in program.kept:
            say(f"    {self.word[kept.name]} := {self.word[f'{kept.name} after']};")
        say("    started := TRUE;")
        say("ELSE")
        say(f"    status := status + {BIT['RESULT_NOT_FINITE']};")
        say("END_IF;")
        return statements

    def _read(self, statements: Statements) -> None:
        say, time = statements.say, self.inside["sample_time"]
        fixed = self.program.sample_time
        good = "(sample_time > 0.0) AND (sample_time <= 1.0E6)"
        if fixed is not None:
            good = f"ABS(sample_time - {real(fixed)}) <= {real(fixed / 1000)}"
        say(f"IF {good} THEN {time} := sample_time;")
        say(f"ELSE status := status + {BIT['SAMPLE_TIME_REFUSED']}; END_IF;")
        longest = longest_sample(self.program)
        if longest is not None:
            long = BIT["SAMPLE_TIME_LONG"]
            say(f"IF {time} > {real(longest.time)} THEN status := status + {long}; END_IF;")
        say("ready := TRUE;")
        for signal in self.program.inputs:
            parameter, accepted = self.word[signal.name], self.inside[signal.name]
            say(
                f"IF ABS({parameter}) <= {LARGEST} THEN {accepted} := {parameter}; "
                "ELSE ready := FALSE; END_IF;"
            )
        say(f"IF NOT ready THEN status := status + {BIT['INPUT_NOT_FINITE']}; END_IF;")
        say("ready := TRUE;")
        for signal in self.program.inputs:
            if signal.range is not None:
                low, high = map(real, reported_range(signal.range))
                accepted = self.inside[signal.name]
                say(
                    f"IF ({accepted} < {low}) OR ({accepted} > {high}) THEN ready := FALSE; END_IF;"
                )
        say(f"IF NOT ready THEN status := status + {BIT['INPUT_OUTSIDE']}; END_IF;")

    def _start(self, statements: Statements, stage_states: Iterable[object]) -> None:
        lookups = dict(statements.found)
        statements.say("IF NOT started THEN")
        statements.indent = "    "
        for state in self.program.kept:
            if state in stage_states:
                statements.say(f"{self.word[state.name]} := {statements.text(state.start)};")
        statements.indent, statements.found = "", lookups
        statements.say("END_IF;")


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
                f"{constant.name} ({constant.place}) has {count} numbers; a function block holds "
                f"{LARGEST_ARRAY}: design with fewer rules (fewer premises, or product bounds), or "
                "write the law with --to c"
            )


def _told(unit: str, meaning: str) -> str:
    """Return unit and meaning as the text of a comment."""
    return told(f"{unit}: {meaning}".removesuffix(": "))


def _page(program: ControllerProgram, word: str) -> str:
    block = f"FB_{word.upper()}"
    rows = [
        f"| `{signal.name}` | {kind} | {signal.unit} | {signal.meaning} |"
        for kind, signals in (("input", program.inputs), ("output", program.outputs))
        for signal in signals
    ]
    first = program.inputs[0].name if program.inputs else "sample_time"
    bits = [f"| {number} | {text} |" for number, _, text in sorted(status_bits(program, REPORTED))]
    return "\n".join(
        [
            f"# {block}: {program.name}",
            "",
            "Written by `takagi export`; the numbers are those of the gain file.",
            "",
            as_list(proof_lines(program)),
            "",
            f"Import `{word}.st`, declare `controller : {block};`, and call it once in every "
            "sample:",
            "",
            "```",
            f"controller({first} := ..., sample_time := 0.01);",
            "```",
            "",
            "| name | | unit | meaning |",
            "|---|---|---|---|",
            *rows,
            "| `sample_time` | input | s | time from one call to the next |",
            "| `reset` | input | | TRUE starts again from the inputs of this call |",
            "",
            "`status` is 0 or a sum of:",
            "",
            "| | |",
            "|---|---|",
            *bits,
            "",
        ]
    )
