"""model.h of an FMU: its variables, and its code at a sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from takagi.reports.code.c.source import CSource
from takagi.reports.code.c.words import comment
from takagi.reports.code.controller_program import ControllerProgram, Signal, identifiers
from takagi.reports.code.sampling import longest_sample

RESERVED = ("time", "sample_time", "status")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the FMU; its place in the list is its value reference.

    Attributes
    ----------
    key : its name in the law; ``name`` is its name in the FMU.
    role : "time", "parameter", "input", "output" or "kept".
    start : value at the start, SI; None where the model computes it.
    """

    key: str
    name: str
    role: str
    unit: str
    description: str
    start: Decimal | None = None
    continuous: bool = False


@dataclass(frozen=True, slots=True)
class FmuModel:
    """A law as an FMU.

    Attributes
    ----------
    word : the model identifier.
    variables : all real variables; the status follows them.
    """

    word: str
    title: str
    program: ControllerProgram
    c: CSource
    variables: tuple[Variable, ...]


def fmu_model(program: ControllerProgram, c: CSource) -> FmuModel:
    """Return the law as a model."""
    # Key, role, unit, description, start and whether it is continuous.
    rows: list[tuple[str, str, str, str, Decimal | None, bool]] = [
        ("time", "time", "s", "", None, True),
        ("sample_time", "parameter", "s", "from one sample of the law to the next",
         c.sample_time, False),
    ]  # fmt: skip
    rows += [
        (
            signal.name,
            "input",
            signal.unit,
            _meaning(signal, program),
            signal.rest or Decimal(0),
            True,
        )
        for signal in program.inputs
    ]
    rows += [
        (signal.name, "output", signal.unit, signal.meaning, None, False)
        for signal in program.outputs
    ]
    rows += [(state.name, "kept", state.unit, state.meaning, None, False) for state in program.kept]
    keys = [key for key, role, _, _, _, _ in rows if role not in ("time", "parameter")]
    names = identifiers(keys, RESERVED, language="an FMU") | {key: key for key in RESERVED}
    variables = tuple(Variable(row[0], names[row[0]], *row[1:]) for row in rows)
    return FmuModel(c.word, program.name, program, c, variables)


def _meaning(signal: Signal, program: ControllerProgram) -> str:
    """Return the meaning of a signal, with the range in which the model holds."""
    sentences = [signal.meaning]
    for state in program.document.get("states", ()):
        if isinstance(state, Mapping) and state.get("name") == signal.name:
            sentences.append(str(state.get("description") or ""))
    if signal.range is not None:
        sentences.append(f"the model holds in [{signal.range[0]}, {signal.range[1]}]")
    return "; ".join(sentence for sentence in sentences if sentence)


def model_header(model: FmuModel, token: str) -> str:
    """Return ``model.h``; an importer must pass ``token`` to show that it has this description."""
    c = model.c
    references = {variable.key: f"AT_{variable.name}" for variable in model.variables}
    kinds = {"input": "MODEL_INPUT", "parameter": "MODEL_PARAMETER"}
    enum = "".join(f"    AT_{variable.name},\n" for variable in model.variables)
    start = "".join(
        f"    {_number(variable.start)}, /* {variable.name} */\n" for variable in model.variables
    )
    kind = "".join(
        f"    {kinds.get(variable.role, 'MODEL_RESULT')},\n" for variable in model.variables
    )
    return f"""/* model.h: {comment(model.title)}
 *
 * Written by takagi.  The law is in {c.word}.c, with the decimals of its gain file.
 */
#ifndef MODEL_H
#define MODEL_H

#include <math.h>
#include <string.h>

#include "{c.word}.h"

#define MODEL_TOKEN "{token}"

/* Value references of the real variables, and after them that of the status. */
enum {{
{enum}    MODEL_REALS
}};
enum {{ MODEL_TIME = AT_time, MODEL_STATUS = MODEL_REALS }};
/* Status bits of normal operation: a command or an estimate at a limit. */
enum {{ MODEL_NORMAL = {c.status_bits["AT_LIMIT"] | c.status_bits["ESTIMATE_HELD"]} }};

/* What may be set: parameters before the first step, inputs always, results never. */
enum {{ MODEL_PARAMETER, MODEL_INPUT, MODEL_RESULT }};
static const unsigned char model_kind[MODEL_REALS] = {{
{kind}}};
static const double model_start[MODEL_REALS] = {{
{start}}};

typedef struct model {{
    double real[MODEL_REALS];
    unsigned status; /* of the last sample */
    {c.word}_state law;
}} model;

static double model_sample_time(const model *m)
{{
    return m->real[AT_sample_time];
}}

/* Ready for the first sample; NULL, or what is wrong. */
static const char *model_prepare(model *m)
{{
    if ({c.word}_init(&m->law, ({c.word}_real)m->real[AT_sample_time]) != 0u) {{
        return "this sample_time cannot be: {_time_needed(model)}";
    }}
    return NULL;
}}

{_sample(model, references)}
static const char *model_message(unsigned status)
{{
    return {c.word}_message(status);
}}

#endif
"""


def _number(value: Decimal | None) -> str:
    return repr(float(value or 0))


def _time_needed(model: FmuModel) -> str:
    fixed_time = model.program.sample_time
    longest = longest_sample(model.program)
    if fixed_time is not None:
        return f"the law is one for {fixed_time} s"
    if longest is not None:
        return f"a time above 0 s and at most {longest.time} s is needed, since {longest.reason}"
    return "a time above 0 s is needed"


def _sample(model: FmuModel, references: Mapping[str, str]) -> str:
    c, word = model.c, model.c.word
    lines = [
        f"in.{member} = ({word}_real)m->real[{references[name]}];"
        for name, member in c.inputs.items()
    ]
    lines.append(f"status = {word}_step(&m->law, &in, &out);")
    lines += _results(c.outputs, references, "out")
    lines += _results(c.kept, references, "m->law.kept")
    body = "".join(f"    {line}\n" for line in lines)
    return f"""/* One sample of the law, with the inputs as they are; returns its status bits. */
static unsigned model_sample(model *m)
{{
    {word}_inputs in;
    {word}_outputs out;
    unsigned status;
{body}    return status;
}}
"""


def _results(
    members: Mapping[str, Any], references: Mapping[str, str], owner: str
) -> Iterable[str]:
    assignments: Sequence[str] = [
        f"m->real[{references[name]}] = (double){owner}.{member};"
        for name, member in members.items()
    ]
    return assignments
