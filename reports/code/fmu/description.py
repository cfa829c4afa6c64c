"""modelDescription.xml of FMI 3.0 and 2.0; and model.h: its variables, and its code at a sample."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any
from xml.sax.saxutils import quoteattr

from takagi.models.errors import ModelError
from takagi.models.files.units import BASE, parse_unit
from takagi.reports.code.c.source import CSource
from takagi.reports.code.controller_program import ControllerProgram, Signal, identifiers
from takagi.reports.code.target_text import filled, proof_lines

# Role -> causality, variability, and how the start is found ("" where that is implied).
KINDS = {
    "time": ("independent", "continuous", ""),
    "parameter": ("parameter", "fixed", "exact"),
    "input": ("input", "continuous", ""),
    "output": ("output", "discrete", "calculated"),
    "kept": ("local", "discrete", "calculated"),
}


def model_description(model: FmuModel, version: int, token: str, sources: Iterable[str]) -> str:
    """Return modelDescription.xml of FMI 2.0 or 3.0; ``sources`` are what a tool compiles."""
    gains = model.program.hashes.get("gains")
    units = dict.fromkeys(v.unit for v in model.variables if v.unit not in ("", "-"))
    status = len(model.variables)
    bits = ", ".join(
        f"{bit} {word.replace('_', ' ').lower()}"
        for word, bit in sorted(model.c.status_bits.items(), key=lambda pair: pair[1])
    )
    words = f"of the last sample, a sum of: {bits}; 0 where all is well"
    context = {
        "model": model,
        "version": version,
        "token": token,
        "sources": sources,
        "proof": " ".join(proof_lines(model.program))
        + (f", SHA-256 of its gains {gains}" if gains else ""),
        "units": [(unit, base_units(unit)) for unit in units],
        "step": float(model.c.sample_time),
        "variables": [
            (_kind(variable.name, k, variable.role, variable.description), _real(variable))
            for k, variable in enumerate(model.variables)
        ],
        "status": _kind("status", status, "output", words),
        "outputs": [
            *(k for k, variable in enumerate(model.variables) if variable.role == "output"),
            status,
        ],
        "quoted": quoteattr,
        "attributes": _attributes,
    }
    return filled("fmu", "modelDescription.xml", context)


def _kind(name: str, reference: int, role: str, description: str) -> dict[str, Any]:
    causality, variability, initial = KINDS[role]
    stated = {
        "name": name,
        "valueReference": reference,
        "causality": causality,
        "variability": variability,
        "initial": initial,
        "description": description,
    }
    return {key: value for key, value in stated.items() if value != ""}


def _real(variable: Variable) -> dict[str, Any]:
    attributes = {} if variable.unit in ("", "-") else {"unit": variable.unit}
    start = variable.start
    return attributes if start is None else {**attributes, "start": float(start)}


def _attributes(values: Mapping[str, Any]) -> str:
    return "".join(f" {key}={quoteattr(str(value))}" for key, value in values.items())


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of kg, m, s, A, K, mol, cd and rad that are not 0.

    None for a text that is no SI unit; signals of a gain file are in SI.
    """
    try:
        parsed = parse_unit(unit)
    except ModelError:
        return None
    powers = parsed.dimension.exponents
    if not parsed.is_si or any(power.denominator != 1 for power in powers):
        return None
    exponents = {name: int(power) for name, power in zip(BASE, powers, strict=True)}
    exponents["rad"] = _radians(unit)
    return {name: power for name, power in exponents.items() if power}


def _radians(unit: str) -> int:
    """Return the exponent of rad, which is a pure number in SI and a base unit in FMI."""
    above, _, below = unit.partition("/")

    def count(text: str) -> int:
        return sum(int(power or 1) for power in re.findall(r"\brad\b(?:\^(-?\d+))?", text))

    return count(above) - count(below)


RESERVED = ("time", "sample_time", "status")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the FMU; its place in the list is its value reference.

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
