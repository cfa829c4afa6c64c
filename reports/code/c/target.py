"""`takagi export --to c`: the law as C99 with a self-test, an example and a README."""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import Decimal

from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.c.words import comment
from takagi.reports.code.controller_program import ControllerProgram, Signal
from takagi.reports.code.proof_words import as_list, proof_lines
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.sampling import longest_sample
from takagi.reports.code.status import status_bits
from takagi.reports.code.targets import Exported, ExportSettings

SAMPLES = 40
# Relative to the largest value of an output in the test.
TOLERANCES = {"double": "1e-9", "float": "1e-3F"}


def self_test(program: ControllerProgram, c: CSource, settings: ExportSettings) -> str:
    """Return ``W_test.c``, which compares the law with known outputs, then gives it a NaN."""
    rows = _known(program, float(c.sample_time))
    suffix = "F" if settings.precision == "float" else ""
    n, m = len(program.inputs), len(program.outputs)
    input_rows = _rows([[values[s.name] for s in program.inputs] for values, _ in rows], suffix)
    output_rows = _rows([[values[s.name] for s in program.outputs] for _, values in rows], suffix)
    largest = [max((abs(o[s.name]) for _, o in rows), default=0) for s in program.outputs]
    tolerance = TOLERANCES[settings.precision]
    sizes = ", ".join(f"{size!r}{suffix}" for size in largest)
    word, W = c.word, c.word.upper()
    put = "".join(f"        in.{c.inputs[s.name]} = given[k][{j}];\n"
                  for j, s in enumerate(program.inputs))  # fmt: skip
    got = "".join(f"        off += differs(k, {j}, out.{c.outputs[s.name]});\n"
                  for j, s in enumerate(program.outputs))  # fmt: skip
    finite = " && ".join(f"isfinite(out.{c.outputs[s.name]})" for s in program.outputs)
    bad = f"in.{c.inputs[program.inputs[0].name]}"
    absolute = "fabsf" if suffix else "fabs"
    title = comment(program.name)
    return f"""/* {word}_test.c: test of {title} with known outputs; returns 0 if it passes. */
#include "{word}.h"

#include <math.h>
#include <stdio.h>

#define SAMPLES {len(rows)}

static const {word}_real given[SAMPLES][{n}] = {{
{input_rows}
}};

/* Correct outputs, computed by takagi from the gain file. */
static const {word}_real wanted[SAMPLES][{m}] = {{
{output_rows}
}};

static const {word}_real largest[{m}] = {{ {sizes} }};

static int differs(int k, int j, {word}_real found)
{{
    if ({absolute}(found - wanted[k][j]) <= {tolerance} * largest[j]) {{
        return 0;
    }}
    printf("sample %d, output %d: %.17g, but %.17g is right\\n", k, j, (double)found,
           (double)wanted[k][j]);
    return 1;
}}

int main(void)
{{
    {word}_state state;
    {word}_inputs in;
    {word}_outputs out;
    int off = 0;
    int k;
    if ({word}_init(&state, {c.sample_time}{suffix}) != 0u) {{
        printf("init refuses the sample time of the law\\n");
        return 1;
    }}
    for (k = 0; k < SAMPLES; k++) {{
{put}        (void){word}_step(&state, &in, &out);
{got}    }}
    {bad} = ({word}_real)NAN;
    if (({word}_step(&state, &in, &out) & {W}_INPUT_NOT_FINITE) == 0u || !({finite})) {{
        printf("an input that is not finite sets no status bit, or reaches an output\\n");
        off++;
    }}
    printf("%s: %d samples, %d values off\\n", off == 0 ? "good" : "BAD", SAMPLES, off);
    return off == 0 ? 0 : 1;
}}
"""


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


def _rows(rows: Iterable[Iterable[float]], suffix: str) -> str:
    return ",\n".join(
        "    { " + ", ".join(f"{value!r}{suffix}" for value in row) + " }" for row in rows
    )


def example(program: ControllerProgram, c: CSource, settings: ExportSettings) -> str:
    """Return ``W_example.c``, a loop that uses every function of the law."""
    suffix = "F" if settings.precision == "float" else ""
    put = "".join(
        f"        in.{c.inputs[s.name]} = {s.rest if s.rest is not None else 0}"
        f"{'' if '.' in str(s.rest) else '.0'}{suffix}; "
        f"/* {comment(f'[{s.unit}] {s.meaning}')} */\n"
        for s in program.inputs
    )
    show = "".join(
        f'        printf(" {c.outputs[s.name]} %g", (double)out.{c.outputs[s.name]});\n'
        for s in program.outputs
    )
    return f"""/* {c.word}_example.c: how to call the law of {comment(program.plant)}. */
#include "{c.word}.h"

#include <stdio.h>

int main(void)
{{
    {c.word}_state state;
    {c.word}_inputs in;
    {c.word}_outputs out;
    int k;

    /* Call this once, with the time between two steps in s. */
    if ({c.word}_init(&state, {c.sample_time}{suffix}) != 0u) {{
        return 1;
    }}
    for (k = 0; k < 5; k++) {{
        unsigned status;
        /* Measure here. */
{put}        status = {c.word}_step(&state, &in, &out);
        /* Send what is in out. */
        printf("%d:", k);
{show}        printf("  (%s)\\n", {c.word}_message(status));
    }}
    return 0;
}}
"""


def page(program: ControllerProgram, c: CSource, settings: ExportSettings) -> str:
    """Return ``README.md``: inputs, outputs, status bits, and how to compile."""
    word, W = c.word, c.word.upper()
    inputs = "".join(
        f"| `{c.inputs[s.name]}` | {s.unit} | {_range(s)} | {'0' if s.rest is None else s.rest} "
        f"| {s.meaning} |\n"
        for s in program.inputs
    )
    outputs = "".join(
        f"| `{c.outputs[s.name]}` | {s.unit} | {s.meaning} |\n" for s in program.outputs
    )
    state_rows = "".join(f"| `{c.kept[s.name]}` | {s.unit} | {s.meaning} |\n" for s in program.kept)
    bits = "".join(
        f"| {bit} | `{W}_{name}` | {text} |\n" for bit, name, text in sorted(status_bits(program))
    )
    fixed = (
        f"The law is in discrete time with {c.sample_time} s; no other sample time is accepted."
        if program.sample_time is not None
        else f"`{word}_init` takes the time between two steps in s; a state without a valid time "
        f"starts with {c.sample_time} s.{_longest(program)}"
    )
    kept_table = (
        f"\n## Kept from step to step\n\n| name | unit | meaning |\n|---|---|---|\n{state_rows}"
    )
    proof = f"""
    takagi check CERTIFICATE --gains GAINS --c-source {word}.c

reads the decimals and formulas back out of `{word}.c` and compares them with the gain file.
""" if program.hashes else ""  # fmt: skip
    origin = "decimals of the gain file" if program.hashes else "figures of the turbine's file"
    return f"""# {program.name}, in C99

{as_list(proof_lines(program))}

The numbers in `{word}.c` are the {origin}, in {settings.precision}.

    cc -std=c99 -O2 -ffp-contract=off {word}.c {word}_test.c -lm -o {word}_test && ./{word}_test
    cc -std=c99 -O2 -ffp-contract=off {word}.c {word}_example.c -lm -o {word}_example

`{word}_test` compares outputs with known ones and returns 0 if they agree. Do not compile with
`-ffast-math`: it removes the checks for numbers that are not finite, and `{word}.c` refuses it.
{proof}
## Inputs

| name | unit | range | at rest | meaning |
|---|---|---|---|---|
{inputs}
An input that is not finite is replaced by the last good one; before the first good one by its value
at rest. Outside the range the input is used as it is, and a status bit says so.

## Outputs

| name | unit | meaning |
|---|---|---|
{outputs}
Outputs are always finite. If a result is not finite, the output keeps its last value.
{kept_table if state_rows else ""}
## Status bits

| bit | word | meaning |
|---|---|---|
{bits}
`{word}_message(status)` says the most serious one in words. {fixed}

There is no allocation, no recursion and no variable outside `{word}_state`. It holds no pointer, so
it can be copied, stored and restored byte by byte.
"""


def _longest(program: ControllerProgram) -> str:
    longest = longest_sample(program)
    return "" if longest is None else f" At most {longest.time} s: {longest.reason}."


def _range(signal: Signal) -> str:
    return "" if signal.range is None else f"{signal.range[0]} to {signal.range[1]}"


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W.h``, ``W.c``, ``W_test.c``, ``W_example.c`` and ``README.md``.

    Raises
    ------
    ModelError : a name, number or sample time that C or the law cannot hold.
    """
    c = c_source(program, settings)
    word = c.word
    files = {
        f"{word}.h": c.header,
        f"{word}.c": c.source,
        f"{word}_test.c": self_test(program, c, settings),
        f"{word}_example.c": example(program, c, settings),
        "README.md": page(program, c, settings),
    }
    use = {
        f"{word}.c": f"compile it: cc -std=c99 -O2 -ffp-contract=off -c {word}.c",
        f"{word}.h": f"{word}_init once, {word}_step at every sample",
        f"{word}_test.c": f"try it: cc {word}.c {word}_test.c -lm && ./a.out",
        f"{word}_example.c": "a loop with every call",
        "README.md": "inputs, outputs, units and status bits",
    }
    return Exported(files, use)
