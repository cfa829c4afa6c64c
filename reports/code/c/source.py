"""Header and source of a law in C99, without allocation, recursion or variable globals."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal

from takagi.reports.code.c.expressions import Expressions, literal, needed_names, sample_function
from takagi.reports.code.c.words import HELPERS, RESERVED, comment, file_name_word, helpers
from takagi.reports.code.controller_program import (
    Constant,
    ControllerProgram,
    Spline,
    file_word,
    identifiers,
)
from takagi.reports.code.program_reading import require_nodes
from takagi.reports.code.proof_words import proof_lines
from takagi.reports.code.sampling import longest_sample, start_sample_time
from takagi.reports.code.status import BIT, reported_range, status_bits
from takagi.reports.code.targets import ExportSettings

# Names that the templates below use, with the prefix: a name of the law must not be one of them.
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
    time = start_sample_time(program, settings.sample_time)
    sections = (
        _opening(program, word, f"{word}.c", settings, time),
        f'#include "{word}.h"\n\n#include <math.h>\n\n{_FAST_MATH}',
        # Helpers come before the constants: a constant then cannot shadow a name inside a helper.
        helpers(write.helpers, f"{word}_", f"{word}_real", suffix),
        "".join(
            constant_text(constant, names[constant.name], word, write)
            for constant in constants.values()
        ),
        sample,
        _calls(program, word, write, time),
    )
    return CSource(
        word=word,
        header=_header(program, word, names, settings, time),
        source="".join(sections),
        inputs={signal.name: names[signal.name] for signal in program.inputs},
        outputs={signal.name: names[signal.name] for signal in program.outputs},
        kept={state.name: names[state.name] for state in program.kept},
        constants={name: names[name] for name in constants},
        status_bits={name: bit for bit, name, _ in status_bits(program)},
        sample_time=time,
    )


_FAST_MATH = """#ifdef __FAST_MATH__
#error "compile without -ffast-math: it takes away the checks for numbers that are not finite"
#endif
"""


def _opening(
    program: ControllerProgram, word: str, file: str, settings: ExportSettings, time: Decimal
) -> str:
    programs = ", ".join(stage.name for stage in program.stages)
    origin, bound = "its numbers are the figures of the turbine's file", ""
    if program.hashes:
        origin = "its numbers are the decimals of a gain file"
        bound = f""" * SHA-256 of its gains: {comment(program.hashes.get("gains", "none"))}
 * Check this text with: takagi check CERTIFICATE --gains GAINS --c-source {word}.c
"""
    proof = "".join(f" * {comment(line)}\n" for line in proof_lines(program))
    return f"""/* {file}: {comment(program.name)}
 *
 * Written by takagi; {origin}.
 * Programs: {comment(programs)}
 * Numbers: {settings.precision}; starts with {time} s
{proof}{bound} */
"""


def _header(
    program: ControllerProgram,
    word: str,
    names: Mapping[str, str],
    settings: ExportSettings,
    time: Decimal,
) -> str:
    guard = f"{word.upper()}_H"
    bits = "".join(
        f"#define {word.upper()}_{name} {bit}u /* {meaning} */\n"
        for bit, name, meaning in sorted(status_bits(program))
    )
    states_member = f"    {word}_kept kept;\n" if program.kept else ""
    longest = longest_sample(program)
    long_words = (
        ""
        if longest is None
        else f""" A time above {longest.time} s is used,
 * but returns {word.upper()}_SAMPLE_TIME_LONG, as every step then does: {longest.reason}."""
    )
    structs = [
        _struct(f"{word}_inputs", ((names[i.name], i.unit, i.meaning) for i in program.inputs)),
        _struct(f"{word}_outputs", ((names[i.name], i.unit, i.meaning) for i in program.outputs)),
    ]
    if program.kept:
        structs.append(
            _struct(f"{word}_kept", ((names[i.name], i.unit, i.meaning) for i in program.kept))
        )
    return f"""{_opening(program, word, f"{word}.h", settings, time)}
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif

typedef {settings.precision} {word}_real;

/* Status bits of a step. */
{bits}
{"".join(structs)}
/* Everything that lasts from step to step. The caller owns it; the library has no other memory.
 * It contains no pointer: to store or restore it, copy it. */
typedef struct {word}_state {{
    unsigned ready;    /* set by {word}_init */
    unsigned samples;  /* 0 before the first step, then 1 */
    {word}_real sample_time; /* s */
    {word}_inputs inputs;    /* the last good ones */
    {word}_outputs outputs;  /* the last that were sent */
{states_member}}} {word}_state;

/* Start; sample_time in s. Returns 0, or {word.upper()}_SAMPLE_TIME_REFUSED. Then the default
 * sample time is used, and the state is valid.{long_words} */
unsigned {word}_init({word}_state *state, {word}_real sample_time);

/* Change the sample time [s]. Returns 0, or {word.upper()}_SAMPLE_TIME_REFUSED: then the one
 * before is kept. */
unsigned {word}_set_sample_time({word}_state *state, {word}_real sample_time);

/* One sample. Outputs are finite whatever the inputs are. Returns status bits, 0 if all is well. */
unsigned {word}_step({word}_state *state, const {word}_inputs *inputs, {word}_outputs *outputs);

/* The most serious status bit in words. */
const char *{word}_message(unsigned status);

#ifdef __cplusplus
}}
#endif

#endif
"""


def _struct(name: str, members: Iterable[tuple[str, str, str]]) -> str:
    kind = name.rsplit("_", 1)[0]
    lines = "".join(
        f"    {kind}_real {member}; /* {comment(f'[{unit}] {meaning}'.strip())} */\n"
        for member, unit, meaning in members
    )
    return f"\ntypedef struct {name} {{\n{lines}}} {name};\n"


def constant_text(constant: Constant, name: str, word: str, write: Expressions) -> str:
    """Return the definition of a constant; its type is ``{word}_real``."""
    note = f"/* {comment(constant.place)} [{comment(constant.unit)}] */"
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


def _calls(program: ControllerProgram, word: str, write: Expressions, sample_time: Decimal) -> str:
    """Return the functions that a user calls, with their checks of state and sample time."""
    W, names, suffix = word.upper(), write.names, write.suffix
    zero, time = literal(Decimal(0), suffix), literal(sample_time, suffix)
    inputs = [names[signal.name] for signal in program.inputs]
    outputs = [names[signal.name] for signal in program.outputs]
    states = [names[state.name] for state in program.kept]
    fixed_time = ""
    # A law in discrete time takes its own T only; the tolerance allows for its rounding to float.
    if program.sample_time is not None:
        tolerance = literal(sample_time * Decimal("1e-6"), suffix)
        fixed_time = f"\n        && fabs{suffix.lower()}(sample_time - {time}) <= {tolerance}"
    longest = longest_sample(program)
    long_time, started, long_step = "", "0u", ""
    if longest is not None:
        started = f"{word}_long_time(state)"
        long_step = f"    status |= {started};\n"
        long_time = f"""
/* A status bit if the sample time is longer than the law allows, else 0. */
static unsigned {word}_long_time(const {word}_state *state)
{{
    return state->sample_time > {literal(longest.time, suffix)} ? {W}_SAMPLE_TIME_LONG : 0u;
}}
"""
    members = [f"inputs.{signal}" for signal in inputs]
    members += [f"outputs.{signal}" for signal in outputs]
    members += [f"kept.{state}" for state in states]
    all_finite = "\n        && ".join(f"isfinite(state->{member})" for member in members)
    rests = "".join(
        f"    state->inputs.{names[signal.name]} = {literal(signal.rest or Decimal(0), suffix)}; "
        f"/* rest, {comment(signal.unit)} */\n"
        for signal in program.inputs
    )
    start = "".join(
        f"    state->outputs.{names[signal.name]} = "
        f"{literal(_rest_of_output(program, signal.name), suffix)};\n"
        for signal in program.outputs
    ) + "".join(f"    state->kept.{state} = {zero};\n" for state in states)
    first = " && ".join(
        [f"isfinite(sent.{signal})" for signal in outputs]
        + [f"isfinite(next.{state})" for state in states]
    )
    target = "&sent, &next" if states else "&sent"
    good = "".join(
        f"""    if (isfinite({source}.{member})) {{
        state->{struct}.{member} = {source}.{member};
    }} else {{
        status |= {W}_RESULT_NOT_FINITE;
    }}
"""
        for source, struct, every in (("sent", "outputs", outputs), ("next", "kept", states))
        for member in every
    )
    messages = "".join(
        f'    if ((status & {W}_{name}) != 0u) {{\n        return "{meaning}";\n    }}\n'
        for _, name, meaning in status_bits(program)
    )
    next_ = f"    {word}_kept next;\n" if states else ""
    return f"""
/* The mark of a state that {word}_init has filled. */
#define {W}_READY 0x54414B41u

static int {word}_good_time({word}_real sample_time)
{{
    return isfinite(sample_time) && sample_time > {zero}{fixed_time};
}}
{long_time}
/* Whether these functions made a state; false for a zeroed or damaged one. */
static int {word}_is_ready(const {word}_state *state)
{{
    return state->ready == {W}_READY && {word}_good_time(state->sample_time)
        && {all_finite};
}}

/* The values before the first sample: inputs and outputs at rest. */
static void {word}_rest({word}_state *state)
{{
{rests}{start}}}

unsigned {word}_init({word}_state *state, {word}_real sample_time)
{{
    const int good = {word}_good_time(sample_time);
    state->ready = {W}_READY;
    state->samples = 0u;
    state->sample_time = good ? sample_time : {time};
    {word}_rest(state);
    return good ? {started} : {W}_SAMPLE_TIME_REFUSED;
}}

unsigned {word}_set_sample_time({word}_state *state, {word}_real sample_time)
{{
    if (!{word}_is_ready(state)) {{
        return {word}_init(state, sample_time) | {W}_NOT_STARTED;
    }}
    if (!{word}_good_time(sample_time)) {{
        return {W}_SAMPLE_TIME_REFUSED;
    }}
    state->sample_time = sample_time;
    return {started};
}}

unsigned {word}_step({word}_state *state, const {word}_inputs *inputs, {word}_outputs *outputs)
{{
    unsigned status = 0u;
    unsigned limits;
    {word}_outputs sent;
{next_}
    if (!{word}_is_ready(state)) {{
        (void){word}_init(state, {time});
        status |= {W}_NOT_STARTED;
    }}
{"".join(_seen(program, word, write))}{long_step}
    limits = {word}_sample(state, &state->inputs, {target});
    if (state->samples == 0u && !({first})) {{
        /* No finite output exists yet: start from rest. */
        status |= {W}_RESULT_NOT_FINITE;
        {word}_rest(state);
        limits = {word}_sample(state, &state->inputs, {target});
    }}
    status |= limits;
{good}    state->samples = 1u;
    *outputs = state->outputs;
    return status;
}}

const char *{word}_message(unsigned status)
{{
{messages}    return "all is well";
}}
"""


def _seen(program: ControllerProgram, word: str, write: Expressions) -> Iterator[str]:
    """Yield the lines that take over finite inputs and set the status bits of the others."""
    for signal in program.inputs:
        name, W = write.names[signal.name], word.upper()
        yield f"    if (isfinite(inputs->{name})) {{\n"
        yield f"        state->inputs.{name} = inputs->{name};\n"
        if signal.range is not None:
            low, high = (literal(end, write.suffix) for end in reported_range(signal.range))
            yield f"        if (inputs->{name} < {low} || inputs->{name} > {high}) {{\n"
            yield f"            status |= {W}_INPUT_OUTSIDE;\n        }}\n"
        yield f"    }} else {{\n        status |= {W}_INPUT_NOT_FINITE;\n    }}\n"
