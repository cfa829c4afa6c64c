"""model.h of an FMU: its variables, its code at a sample, and its code between samples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from takagi.reports.code.c.source import CSource
from takagi.reports.code.c.words import comment
from takagi.reports.code.controller_program import ControllerProgram, Signal
from takagi.reports.code.fmu.plant_equations import PlantEquations
from takagi.reports.code.fmu.plant_source import plant_source
from takagi.reports.code.identifiers import identifiers
from takagi.reports.code.sampling import longest_sample

RESERVED = ("time", "sample_time", "integration_step", "status")
# Steps of the plant's integration in a sample, if the user states none.
INNER_STEPS = 10


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the FMU; its place in the list is its value reference.

    Attributes
    ----------
    key : its name in the law or plant; ``name`` is its name in the FMU.
    role : "time", "parameter", "input", "state", "output" or "kept".
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
    """A law, alone or with its plant, as an FMU.

    Attributes
    ----------
    word : the model identifier.
    variables : all real variables; the status follows them.
    plant : None for the law alone.
    """

    word: str
    title: str
    program: ControllerProgram
    c: CSource
    variables: tuple[Variable, ...]
    plant: PlantEquations | None = None


def fmu_model(
    program: ControllerProgram, c: CSource, plant: PlantEquations | None = None
) -> FmuModel:
    """Return the law as a model of its own, or in loop with its plant."""
    # Key, role, unit, description, start and whether it is continuous.
    parts: list[tuple[str, str, str, str, Decimal | None, bool]] = [
        ("time", "time", "s", "", None, True),
        ("sample_time", "parameter", "s", "from one sample of the law to the next",
         c.sample_time, False),
    ]  # fmt: skip
    if plant is not None and not plant.discrete:
        parts.append(
            ("integration_step", "parameter", "s", "longest step of the plant's integration",
             c.sample_time / INNER_STEPS, False)
        )  # fmt: skip
    given = program.inputs if plant is None else plant.disturbances
    parts += [
        (one.name, "input", one.unit, _meaning(one, program), one.rest or Decimal(0), True)
        for one in given
    ]
    if plant is not None:
        parts += [
            (one.name, "state", one.unit, one.meaning, one.start, not plant.discrete)
            for one in plant.states
        ]
    parts += [(one.name, "output", one.unit, one.meaning, None, False) for one in program.outputs]
    parts += [(one.name, "kept", one.unit, one.meaning, None, False) for one in program.kept]
    own = [key for key, role, _, _, _, _ in parts if role not in ("time", "parameter")]
    names = identifiers(own, RESERVED, language="an FMU") | {key: key for key in RESERVED}
    word = c.word if plant is None else f"{c.word}_loop"
    title = program.name if plant is None else f"{program.name}: the closed loop"
    return FmuModel(
        word,
        title,
        program,
        c,
        tuple(Variable(part[0], names[part[0]], *part[1:]) for part in parts),
        plant,
    )


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
    c, plant = model.c, model.plant
    places = {one.key: f"AT_{one.name}" for one in model.variables}
    kinds = {"input": "MODEL_INPUT", "parameter": "MODEL_PARAMETER", "state": "MODEL_PARAMETER"}
    enum = "".join(f"    AT_{one.name},\n" for one in model.variables)
    start = "".join(f"    {_number(one.start)}, /* {one.name} */\n" for one in model.variables)
    kind = "".join(f"    {kinds.get(one.role, 'MODEL_RESULT')},\n" for one in model.variables)
    waiting = ""
    if plant is not None and plant.discrete:
        waiting = f"    double next[{len(plant.states)}]; /* states at the next sample */\n"
        waiting += "    int waits; /* whether they have not been reached */\n"
    moves = NO_PLANT
    if plant is not None:
        moves = plant_source(plant, places, places[plant.states[0].name])
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
{waiting}}} model;
{moves}
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
{_prepared(model, places)}    return NULL;
}}

{_sample(model, places)}
static int model_is_finite(const model *m)
{{
    return {_finite(model, places)};
}}

static const char *model_message(unsigned status)
{{
    return {c.word}_message(status);
}}

#endif
"""


NO_PLANT = """
static void model_move(model *m, double time)
{
    (void)m; /* what was sent is held */
    (void)time;
}

static void model_arrive(model *m)
{
    (void)m;
}
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


def _prepared(model: FmuModel, places: Mapping[str, str]) -> str:
    text = ""
    if "integration_step" in places:
        text += """    if (!isfinite(m->real[AT_integration_step])
        || !(m->real[AT_sample_time] <= 1e6 * m->real[AT_integration_step])) {
        return "this integration_step cannot be: it is a millionth of sample_time or more";
    }
"""
    if model.plant is not None:
        text += f"""    if (!({_finite(model, places)})) {{
        return "the plant has to start from finite states";
    }}
"""
    return text


def _finite(model: FmuModel, places: Mapping[str, str]) -> str:
    """Return the condition that all states are finite; outputs of the law always are."""
    if model.plant is None:
        return "m != NULL"
    return "\n        && ".join(f"isfinite(m->real[{places[s.name]}])" for s in model.plant.states)


def _sample(model: FmuModel, places: Mapping[str, str]) -> str:
    c, word, plant = model.c, model.c.word, model.plant

    def source(name: str) -> str:
        return places[name if plant is None else plant.measured[name]]

    lines = [
        f"in.{member} = ({word}_real)m->real[{source(name)}];" for name, member in c.inputs.items()
    ]
    lines.append(f"status = {word}_step(&m->law, &in, &out);")
    lines += _results(c.outputs, places, "out")
    lines += _results(c.kept, places, "m->law.kept")
    if plant is not None:
        lines.append("plant_next(m);")
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
