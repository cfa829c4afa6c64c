"""The target `c`: a law as C99 without allocation, recursion or variable globals.

With a self-test, an example and a README.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from takagi.reports.code.c.expressions import (
    HELPERS,
    RESERVED,
    Expressions,
    comment,
    file_name_word,
    helpers,
    literal,
    needed_names,
    sample_function,
)
from takagi.reports.code.controller_program import (
    Constant,
    ControllerProgram,
    Signal,
    Spline,
    file_word,
    identifiers,
)
from takagi.reports.code.program_reading import require_nodes
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import BIT, Exported, ExportSettings, filled, shared_context

# Names that the templates use, with the prefix: a name of the law must not be one of them.
TEMPLATE_WORDS = (
    "real", "kept", "state", "inputs", "outputs", "init", "step", "message", "sample", "rest",
    "is_ready", "good_time", "long_time", "set_sample_time",
    *(f"weights_{k}" for k in range(1, 100)), *(f"premises_{k}" for k in range(1, 100)),
)  # fmt: skip
TEMPLATE_MACROS = ("H", "READY", *BIT)


@dataclass(frozen=True, slots=True)
class CSource:
    """A law in C.

    Attributes
    ----------
    word : the prefix ``W`` of its functions and types, and the name of its files.
    header, source : texts of ``W.h`` and ``W.c``.
    inputs, outputs, kept, constants : name in the program -> name of the member or constant in C.
    status_bits : word of a bit, without the prefix -> its value.
    sample_time : T [s] of a state that was not given a valid one.
    context : what its templates were filled with.
    """

    word: str
    header: str
    source: str
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    kept: Mapping[str, str]
    constants: Mapping[str, str]
    status_bits: Mapping[str, int]
    sample_time: Decimal
    context: Mapping[str, Any]


def c_source(program: ControllerProgram, settings: ExportSettings) -> CSource:
    """Return header and source of a program.

    Raises
    ------
    ModelError : a name or number that C cannot hold.
    """
    require_nodes(program, settings.precision)
    word = file_name_word(file_word(program.plant))
    suffix = "F" if settings.precision == "float" else ""
    reserved = {
        *RESERVED,
        word,
        *(f"{word}_{name}" for name in (*TEMPLATE_WORDS, *HELPERS)),
        *(f"{word.upper()}_{macro}" for macro in TEMPLATE_MACROS),
        *(f"{constant.name}_knots_{k}" for constant in program.constants for k in (1, 2)),
    }
    names = identifiers((*program.names(), "sample_time"), reserved, language="C")
    needed = needed_names(program)
    constants = {
        constant.name: constant for constant in program.constants if constant.name in needed
    }
    write = Expressions(names, constants, f"{word}_", suffix)
    sample = sample_function(program, word, needed, write)
    context = _context(program, settings, word, write) | {"sample": sample}
    inputs, outputs, kept = (
        {entry.name: names[entry.name] for entry in entries}
        for entries in (program.inputs, program.outputs, program.kept)
    )
    return CSource(
        word=word,
        header=filled("c", "law.h", context),
        source=filled("c", "law.c", context),
        inputs=inputs,
        outputs=outputs,
        kept=kept,
        constants={name: names[name] for name in constants},
        status_bits={name: bit for bit, name, _ in context["status"]},
        sample_time=context["time"],
        context=context,
    )


def _context(
    program: ControllerProgram, settings: ExportSettings, word: str, write: Expressions
) -> dict[str, Any]:
    """Return what the templates are filled with, but for the function of a sample."""
    names, suffix = write.names, write.suffix
    shared = shared_context(program, settings)
    outputs, kept = (
        [names[entry.name] for entry in entries] for entries in (program.outputs, program.kept)
    )
    members = [f"inputs.{names[signal.name]}" for signal in program.inputs]
    members += [f"outputs.{name}" for name in outputs] + [f"kept.{name}" for name in kept]
    sent = [f"sent.{name}" for name in outputs] + [f"next.{name}" for name in kept]
    return shared | {
        "precision": settings.precision,
        "suffix": suffix,
        # A law in discrete time takes its own T only; this allows for its rounding to float.
        "tolerance": shared["time"] * Decimal("1e-6"),
        "word": word,
        "W": word.upper(),
        "names": names,
        "members": members,
        "first": " && ".join(f"isfinite({member})" for member in sent),
        # Helpers come before the constants: a constant then cannot shadow a name inside a helper.
        "helpers": helpers(write.helpers, f"{word}_", f"{word}_real", suffix),
        "constants": "".join(
            constant_text(constant, names[constant.name], word, write)
            for constant in write.constants.values()
        ),
        "comment": comment,
        "number": lambda value: literal(Decimal(value or 0), suffix),
        "rest_of_output": lambda name: _rest_of_output(program, name),
    }


def constant_text(constant: Constant, name: str, word: str, write: Expressions) -> str:
    """Return the definition of a constant; its type is ``{word}_real``."""
    note = f"/* {comment(constant.path)} [{comment(constant.unit)}] */"
    value = constant.value
    if isinstance(value, Decimal):
        return f"\n{note}\nstatic const {word}_real {name} = {literal(value, write.suffix)};\n"
    if isinstance(value, Spline):
        knots = "".join(
            _array(f"{name}_knots_{k}", (row,), f"{word}_real", write.suffix)
            for k, row in enumerate(value.knots, start=1)
        )
        return f"\n{note}\n{knots}{_array(name, value.coefficients, f'{word}_real', write.suffix)}"
    if isinstance(value[0], tuple):
        # Only rules are matrices.
        rows = ",\n".join("    " + ", ".join(str(int(v)) for v in row) for row in value)
        size = sum(len(row) for row in value)
        return f"\n{note}\nstatic const unsigned char {name}[{size}] = {{\n{rows}\n}};\n"
    return f"\n{note}\n" + _array(name, (value,), f"{word}_real", write.suffix)


def _array(name: str, rows: Iterable[tuple[Decimal, ...]], real: str, suffix: str) -> str:
    texts = [[literal(value, suffix) for value in row] for row in rows]
    size = sum(map(len, texts))
    body = ",\n".join(",\n".join(_filled(row)) for row in texts)
    return f"static const {real} {name}[{size}] = {{\n{body}\n}};\n"


def _filled(numbers: list[str]) -> Iterator[str]:
    """Yield lines of at most 96 characters."""
    line = "   "
    for number in numbers:
        if len(line) + len(number) + 2 > 96:
            yield line.removesuffix(",")
            line = "   "
        line += f" {number},"
    yield line.removesuffix(",")


def _rest_of_output(program: ControllerProgram, name: str) -> Decimal:
    """Return the value of an output before the first sample: its rest in the file, or 0."""
    for entry in program.document.get("inputs", ()):
        if isinstance(entry, Mapping) and entry.get("name") == name:
            return Decimal(entry.get("rest") or 0)
    return Decimal(0)


SAMPLES = 40
# Relative to the largest value of an output in the test.
TOLERANCES = {"double": "1e-9", "float": "1e-3F"}


def _known(
    program: ControllerProgram, sample_time: float
) -> list[tuple[dict[str, float], dict[str, float]]]:
    """Return inputs and outputs of each sample, up to the first without a finite value."""
    run = ProgramRun(program)
    samples: list[tuple[dict[str, float], dict[str, float]]] = []
    for k in range(SAMPLES):
        inputs = {s.name: wave(s, k, j) for j, s in enumerate(program.inputs)}
        try:
            outputs = run.sample(sample_time, inputs)
        except (ArithmeticError, ValueError):
            break
        if not all(map(math.isfinite, (*outputs.values(), *run.kept.values()))):
            break
        samples.append((inputs, outputs))
    return samples or [
        ({s.name: 0.0 for s in program.inputs}, {s.name: 0.0 for s in program.outputs})
    ]


def wave(signal: Signal, k: int, j: int) -> float:
    """Return a test value of input j at sample k, inside its range.

    It has 12 significant bits, so that float and double hold it exactly.
    """
    low, high = signal.range or (Decimal(-1), Decimal(1))
    share = (1 + math.sin(0.37 * k + 1.1 * j)) / 2 * 0.6 + 0.2
    value = float(low) + share * float(high - low)
    size = 2.0 ** (12 - math.frexp(value)[1])
    return round(value * size) / size


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W.h``, ``W.c``, ``W_test.c``, ``W_example.c`` and ``README.md``.

    Raises
    ------
    ModelError : a name, number or sample time that C or the law cannot hold.
    """
    c = c_source(program, settings)
    word, context = c.word, c.context
    samples = _known(program, float(c.sample_time))

    def row(values: Mapping[str, float], signals: Iterable[Signal]) -> str:
        return ", ".join(f"{values[s.name]!r}{context['suffix']}" for s in signals)

    test = {
        "samples": samples,
        "largest": {
            s.name: max(abs(outputs[s.name]) for _, outputs in samples) for s in program.outputs
        },
        "tolerance": TOLERANCES[settings.precision],
        "row": row,
    }
    files = {
        f"{word}.h": c.header,
        f"{word}.c": c.source,
        f"{word}_test.c": filled("c", "test.c", {**context, **test}),
        f"{word}_example.c": filled("c", "example.c", context),
        "README.md": filled("c", "README.md", context),
    }
    use = {
        f"{word}.c": f"compile it: cc -std=c99 -O2 -ffp-contract=off -c {word}.c",
        f"{word}.h": f"{word}_init once, {word}_step at every sample",
        f"{word}_test.c": f"try it: cc {word}.c {word}_test.c -lm && ./a.out",
        f"{word}_example.c": "a loop with every call",
        "README.md": "inputs, outputs, units and status bits",
    }
    return Exported(files, use)
