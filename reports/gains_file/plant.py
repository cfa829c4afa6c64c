r"""The gain file of a plant: the law by rules with all that is needed to run it.

    u = u* - sum_i h_i(z) K_i (x - x*)

``law`` is, number by number, the member ``gains`` of the certificate, so that
``takagi check certificate.json --gains gains.json`` compares equal.  What is proved is about these
decimals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict

from takagi.reports.gains_file.envelope import (
    Envelope,
    RemovableEntry,
    SplineEntry,
    Strict,
    file_schema,
    validated,
)

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign


class PdcLawEntry(BaseModel):
    """The law, as the certificate states it."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)

    name: Literal["pdc"]
    state_names: list[str]
    input_names: list[str]
    K: list[list[list[float]]]
    sample_time: float | None


class DisturbanceEntry(Strict):
    """A disturbance or scheduling signal, which premises may be in: rest, unit, range."""

    name: str
    unit: str
    rest: float
    range: list[float] | None


class SignalEntry(DisturbanceEntry):
    """A state or input: where it rests, its unit, and the range in which the model holds."""

    description: str


class MeasuredEntry(Strict):
    """A measured output by the name under which the program reads it; rest of a state alone."""

    name: str
    output: str
    unit: str
    expression: str
    rest: float | None
    range: list[float] | None


class PlantGainFile(Envelope):
    """The whole file."""

    plant: str
    law: PdcLawEntry
    states: list[SignalEntry]
    inputs: list[SignalEntry]
    signals: list[DisturbanceEntry]
    parameters: dict[str, float]
    tables: dict[str, SplineEntry]
    formulas: dict[str, str]
    removable: dict[str, list[RemovableEntry]]
    notes: list[str]


class OutputGainFile(PlantGainFile):
    """The whole file of a law that has outputs in the place of states."""

    measured: list[MeasuredEntry]


def plant_gain_file(design: PlantDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, see ``envelope.validated``.

    Raises ValueError: an analysis has no gains to write.
    """
    if design.gains is None or (design.law or design.output_law) is None:
        raise ValueError(
            f"plant {design.plant.name!r} has no inputs, so there are no gains to write"
        )
    body = PlantGainFile if design.output_law is None else OutputGainFile
    return validated(design.document, body)


def plant_gain_file_schema(*, outputs: bool = False) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a plant's ``gains.json``.

    outputs : of a law that has measured outputs in the place of states.
    """
    body = OutputGainFile if outputs else PlantGainFile
    return file_schema(body, "takagi gain file of a plant")
