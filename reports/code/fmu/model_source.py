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
    parts: list[tuple[str, str, str, str, Decimal | None, bool]] = [
        ("time", "time", "s", "", None, True),
        ("sample_time", "parameter", "s", "from one sample of the law to the next",
         c.sample_time, False),
    ]  # fmt: skip
    parts += [
        (one.name, "input", one.unit, _meaning(one, program), one.rest or Decimal(0), True)
        for one in program.inputs
    ]
    parts += [(one.name, "output", one.unit, one.meaning, None, False) for one in program.outputs]
    parts += [(one.name, "kept", one.unit, one.meaning, None, False) for one in program.kept]
    own = [key for key, role, _, _, _, _ in parts if role not in ("time", "parameter")]
    names = identifiers(own, RESERVED, language="an FMU") | {key: key for key in RESERVED}
    variables = tuple(Variable(part[0], names[part[0]], *part[1:]) for part in parts)
    return FmuModel(c.word, program.name, program, c, variables)


def _meaning(signal: Signal, program: ControllerProgram) -> str:
    """Return the meaning of a signal, with the range in which the model holds."""
    parts = [signal.meaning]
    for one in program.document.get("states", ()):
        if isinstance(one, Mapping) and one.get("name") == signal.name:
            parts.append(str(one.get("description") or ""))
    if signal.range is not None:
        parts.append(f"the model holds in [{signal.range[0]}, {signal.range[1]}]")
    return "; ".join(part for part in parts if part)


def model_header(model: FmuModel, token: str) -> str:
    """Return ``model.h``; an importer must pass ``token`` to show that it has this description."""
    c = model.c
    places = {one.key: f"AT_{one.name}" for one in model.variables}
    kinds = {"input": "MODEL_INPUT", "parameter": "MODEL_PARAMETER"}
    enum = "".join(f"    AT_{one.name},\n" for one in model.variables)
    start = "".join(f"    {_number(one.start)}, /* {one.name} */\n" for one in model.variables)
    kind = "".join(f"    {kinds.get(one.role, 'MODEL_RESULT')},\n" for one in model.variables)
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

{_sample(model, places)}
static const char *model_message(unsigned status)
{{
    return {c.word}_message(status);
}}

#endif
"""


def _number(value: Decimal | None) -> str:
    return repr(float(value or 0))


def _time_needed(model: FmuModel) -> str:
    own = model.program.sample_time
    longest = longest_sample(model.program)
    if own is not None:
        return f"the law is one for {own} s"
    if longest is not None:
        return f"a time above 0 s and at most {longest.time} s is needed, since {longest.reason}"
    return "a time above 0 s is needed"


def _sample(model: FmuModel, places: Mapping[str, str]) -> str:
    c, word = model.c, model.c.word
    lines = [
        f"in.{member} = ({word}_real)m->real[{places[name]}];" for name, member in c.inputs.items()
    ]
    lines.append(f"status = {word}_step(&m->law, &in, &out);")
    lines += _results(c.outputs, places, "out")
    lines += _results(c.kept, places, "m->law.kept")
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


def _results(members: Mapping[str, Any], places: Mapping[str, str], owner: str) -> Iterable[str]:
    found: Sequence[str] = [
        f"m->real[{places[name]}] = (double){owner}.{member};" for name, member in members.items()
    ]
    return found
