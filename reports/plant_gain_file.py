r"""The gain file of a plant: the law by rules with all that is needed to run it.

    u = u* - sum_i h_i(z) K_i (x - x*)

``law`` is, number by number, the member ``gains`` of the certificate, so that
``takagi check certificate.json --gains gains.json`` compares equal.  What is proved is about these
decimals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict

from takagi.reports.gain_file_schema import FORMAT, ClaimEntry

if TYPE_CHECKING:
    from takagi.certificates.plant_design import PlantDesign

__all__ = ["PlantGainFile", "plant_gain_file", "plant_gain_file_schema"]

VERSION = 1

FORMULAS = {
    "command": "u = u* - sum over rules i of h_i K_i (x - x*)",
    "memberships": "h_i = product over premises of (upper - z)/(upper - lower) at corner 0, "
    "(z - lower)/(upper - lower) at corner 1; a premise with lower = upper has one corner",
    "rules": "law.rules has the corner of each premise, one row per rule, in the order of law.K; "
    "law.K with one matrix is one gain for all rules",
    "outside": "a premise outside its range is held at the nearer end; nothing is proved there",
    "sampling": "with sample_time T the command is computed at every T and held; without, the law "
    "is continuous, and what is proved is about continuous time",
}


BLEND = {
    "blend": "u = u* - ... is the rate of law.blending.effort, U; low: idle - direction psi(-U)/b, "
    "high: idle + direction psi(U)/b, with b the actuator's effectiveness, in SI",
    "ramp": "psi(s) = 0 for s <= -overlap, (s + overlap)^2/(4 overlap) up to overlap, s above",
    "share": "F = (psi(U) - psi(U*))/(U - U*), psi'(U*) where U = U*; a premise in it is measured; "
    "gains do not depend on a premise in an actuator's error, take 0 for the error",
}


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class PdcLawEntry(BaseModel):
    """The law, as the certificate states it."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)

    name: Literal["pdc"]
    state_names: list[str]
    input_names: list[str]
    K: list[list[list[float]]]
    sample_time: float | None


class SignalEntry(_Entry):
    """A state or input: where it rests, its unit, and the range in which the model holds."""

    name: str
    unit: str
    rest: float
    range: list[float] | None
    description: str


class PlantCertificateEntry(_Entry):
    """What the certificate beside this file says about the law."""

    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    claims: list[ClaimEntry]
    sha256: dict[str, str]


class PlantGainFile(_Entry):
    """The whole file."""

    format: Literal["takagi-gains"]
    version: Literal[1]
    name: str
    plant: str
    units: dict[str, str]
    law: PdcLawEntry
    states: list[SignalEntry]
    inputs: list[SignalEntry]
    formulas: dict[str, str]
    notes: list[str]
    certificate: PlantCertificateEntry


def plant_gain_file(design: PlantDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, checked against its schema.

    Raises
    ------
    ValueError : an analysis has no gains to write.
    pydantic.ValidationError : a law whose members do not fit.
    """
    plant, law = design.plant, design.law
    if law is None or design.gains is None:
        raise ValueError(f"plant {plant.name!r} has no inputs, so there are no gains to write")
    rests = [*zip(plant.states, law.state_rest, strict=True)]
    held = [*zip(plant.inputs, law.input_rest, strict=True)]
    found: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "name": f"{plant.name}, law by rules",
        "plant": plant.name,
        "units": {
            **{f"K, {u.name} per {x.name}": _per(u.unit, x.unit) for u in plant.inputs
               for x in plant.states},
            "sample_time": "s",
        },
        "law": design.document["gains"],
        "states": [_signal(variable, rest) for variable, rest in rests],
        "inputs": [_signal(variable, rest) for variable, rest in held],
        "formulas": FORMULAS | (BLEND if plant.blending is not None else {}),
        "notes": list(design.notes),
        "certificate": {
            "verdict": design.verdict.name,
            "claims": [
                {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
                for claim in design.checked.claims
            ],
            "sha256": dict(design.document["provenance"]["sha256"]),
        },
    }  # fmt: skip
    PlantGainFile.model_validate(found)
    return found


def plant_gain_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a plant's ``gains.json``."""
    return {
        **PlantGainFile.model_json_schema(),
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi gain file of a plant",
    }


def _signal(variable: Any, rest: float) -> dict[str, Any]:
    side = variable.range
    return {
        "name": variable.name,
        "unit": variable.unit,
        "rest": float(rest),
        "range": None if side is None else [float(side.lower), float(side.upper)],
        "description": variable.description,
    }


def _per(above: str, below: str) -> str:
    """Return a unit over another, e.g. ``"N/(rad/s)"``."""
    if below == "-":
        return above
    top = "1" if above == "-" else above if " " not in above and "/" not in above else f"({above})"
    return f"{top}/{below}" if " " not in below and "/" not in below else f"{top}/({below})"
