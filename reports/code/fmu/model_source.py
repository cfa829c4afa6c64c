"""model.h of an FMU: its variables, and its code at a sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal

from takagi.reports.code.c.source import CSource
from takagi.reports.code.controller_program import ControllerProgram, Signal, identifiers
from takagi.reports.code.target_text import filled

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


@dataclass(frozen=True, slots=True)
class FmuModel:
    """A law as an FMU.

    Attributes
    ----------
    variables : all real variables; the status follows them.
    """

    program: ControllerProgram
    c: CSource
    variables: tuple[Variable, ...]


def fmu_model(program: ControllerProgram, c: CSource) -> FmuModel:
    """Return the law as a model."""
    what = "from one sample of the law to the next"
    # Key, role, unit, description, start.
    rows: list[tuple[str, str, str, str, Decimal | None]] = [
        ("time", "time", "s", "", None),
        ("sample_time", "parameter", "s", what, c.sample_time),
        *(
            (s.name, "input", s.unit, _meaning(s, program), s.rest or Decimal(0))
            for s in program.inputs
        ),
        *((s.name, "output", s.unit, s.meaning, None) for s in program.outputs),
        *((s.name, "kept", s.unit, s.meaning, None) for s in program.kept),
    ]
    keys = [key for key, role, *_ in rows if role not in ("time", "parameter")]
    names = identifiers(keys, RESERVED, language="an FMU") | {key: key for key in RESERVED}
    variables = tuple(Variable(row[0], names[row[0]], *row[1:]) for row in rows)
    return FmuModel(program, c, variables)


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
    bits = model.c.status_bits
    own = {
        "token": token,
        "variables": model.variables,
        "at": {variable.key: f"AT_{variable.name}" for variable in model.variables},
        "law": model.c,
        "normal": bits["AT_LIMIT"] | bits["ESTIMATE_HELD"],
    }
    return filled("fmu", "model.h", {**model.c.context, **own})
