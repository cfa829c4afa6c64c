r"""The gain file of a plant: the law by rules with all that is needed to run it.

    u = u* - sum_i h_i(z) K_i (x - x*)

``law`` is, number by number, the member ``gains`` of the certificate, so that
``takagi check certificate.json --gains gains.json`` compares equal.  What is proved is about these
decimals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict

from takagi.certificates.controller.content import gain_file_of
from takagi.reports.gains_file.schema import (
    ClaimEntry,
    ProgramEntry,
    RemovableEntry,
    SplineEntry,
)

if TYPE_CHECKING:
    from takagi.certificates.design.plant.design import PlantDesign

__all__ = ["PlantGainFile", "plant_gain_file", "plant_gain_file_schema"]


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


class DisturbanceEntry(_Entry):
    """A disturbance or scheduling signal, which premises may be in."""

    name: str
    unit: str
    rest: float
    range: list[float] | None


class PlantCertificateEntry(_Entry):
    """What the certificate beside this file says about the law."""

    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    claims: list[ClaimEntry]
    sha256: dict[str, str]


class PlantGainFile(_Entry):
    """The whole file."""

    format: Literal["takagi-gains"]
    version: Literal[3]
    name: str
    plant: str
    units: dict[str, str]
    law: PdcLawEntry
    states: list[SignalEntry]
    inputs: list[SignalEntry]
    signals: list[DisturbanceEntry]
    parameters: dict[str, float]
    tables: dict[str, SplineEntry]
    formulas: dict[str, str]
    removable: dict[str, list[RemovableEntry]]
    notes: list[str]
    language: dict[str, str]
    programs: list[ProgramEntry]
    certificate: PlantCertificateEntry


def plant_gain_file(design: PlantDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, checked against its schema.

    Raises
    ------
    ValueError : an analysis has no gains to write.
    pydantic.ValidationError : a law whose members do not fit.
    """
    if design.law is None or design.gains is None:
        raise ValueError(
            f"plant {design.plant.name!r} has no inputs, so there are no gains to write"
        )
    found = gain_file_of(design.document)
    PlantGainFile.model_validate(found)
    return found


def plant_gain_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a plant's ``gains.json``."""
    return {
        **PlantGainFile.model_json_schema(),
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi gain file of a plant",
    }
