"""`takagi export --to c`: the law as C99 with a self-test, an example and a README."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from decimal import Decimal

from takagi.reports.code.c.source import c_source
from takagi.reports.code.controller_program import ControllerProgram, Signal
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.target_text import as_list, filled
from takagi.reports.code.targets import Exported, ExportSettings

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

    Raises ModelError: a name, number or sample time that C or the law cannot hold.
    """
    c = c_source(program, settings)
    word, context = c.word, {**c.context, "as_list": as_list}
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
        f"{word}_test.c": filled("c", "test.c", context | test),
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
