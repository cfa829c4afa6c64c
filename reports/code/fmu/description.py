"""modelDescription.xml of FMI 3.0 and 2.0."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

from takagi.models.errors import ModelError
from takagi.models.files.units import BASE, parse_unit
from takagi.reports.code.fmu.model_source import FmuModel, Variable
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
