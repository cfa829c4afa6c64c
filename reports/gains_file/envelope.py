"""What every gain file has in common: the entries that both bodies use, and the file's text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from takagi.certificates.controller.content import gain_file_of

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.certificates.design.turbine.result import TurbineDesign

Numbers: TypeAlias = list[float]

# Members whose entries stand on lines of their own.
LISTED = ("language", "programs", "states", "inputs")


class Strict(BaseModel):
    """Unknown fields are refused; numbers must be finite; nothing is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class SplineEntry(Strict):
    """A cubic spline: a full row of knots for each argument, and the coefficients."""

    knots: list[Numbers] = Field(min_length=1, max_length=2)
    coefficients: list[Numbers] | Numbers


class ClaimEntry(Strict):
    """One claim of the certificate and what the checker says."""

    name: str
    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    text: str


class NameEntry(Strict):
    """The place of a name's value in the file."""

    value: str
    unit: str


class ReadEntry(Strict):
    """A signal that is read at every sample."""

    name: str
    unit: str
    meaning: str


class KeepEntry(Strict):
    """A value that is kept from one sample to the next."""

    name: str
    unit: str
    start: str
    next: str
    meaning: str


class NearEntry(Strict):
    """The polynomial that replaces a step's formula where |of| <= within."""

    of: str
    within: float = Field(ge=0)
    formula: str


class RemovableEntry(NearEntry):
    """The same for a premise, with the limit where it is 0/0."""

    limit: str


class StepEntry(Strict):
    """One assignment."""

    set: str
    unit: str
    formula: str
    meaning: str


class NearStepEntry(StepEntry):
    """One assignment with other formulas near some points."""

    near: list[RemovableEntry | NearEntry]


class SendEntry(Strict):
    """A signal that is sent at every sample."""

    name: str
    unit: str
    formula: str
    meaning: str


class ProgramEntry(Strict):
    """One sample of a part of the controller; ``language`` says how it is read."""

    name: str
    names: dict[str, NameEntry]
    read: list[ReadEntry]
    keep: list[KeepEntry]
    steps: list[NearStepEntry | StepEntry]
    send: list[SendEntry]


class CertificateEntry(Strict):
    """What the certificate beside this file says about the law."""

    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    claims: list[ClaimEntry]
    sha256: dict[str, str]


class SamplingEntry(Strict):
    """The longest time from sample to sample, and why; None where none is known."""

    longest: float | None = Field(gt=0, description="[s]; exports refuse a longer one")
    reason: str


class Envelope(Strict):
    """The members of every gain file; a body adds its own."""

    format: Literal["takagi-gains"]
    version: Literal[3]
    name: str
    units: dict[str, str]
    language: dict[str, str]
    programs: list[ProgramEntry]
    sampling: SamplingEntry | None = Field(default=None, description="none in files of before")
    certificate: CertificateEntry


def validated(document: Mapping[str, Any], body: type[Envelope]) -> dict[str, Any]:
    """Return the gain file of a certificate as plain data, checked against a body's schema.

    ``law`` is the certificate's ``gains``, number by number.

    Raises
    ------
    pydantic.ValidationError : a law whose members do not fit.
    """
    content = gain_file_of(document)
    body.model_validate(content)
    return content


def file_schema(body: type[Envelope], title: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a gain file with this body."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **body.model_json_schema(),
        "title": title,
    }


def dump_gains(content: dict[str, Any]) -> str:
    """Return the file's text: a line for each step, the same bytes for the same numbers."""
    texts = {
        key: _lines(value, 2 if key == "programs" else 0)
        if key in LISTED
        else json.dumps(value, allow_nan=False)
        for key, value in content.items()
    }
    body = ",\n".join(f"{json.dumps(key)}: {text}" for key, text in texts.items())
    return f"{{\n{body}\n}}\n"


def _lines(value: Any, depth: int, indent: str = "  ") -> str:
    """Return a value with its entries on lines of their own, to some depth."""
    inner = [json.dumps(part, allow_nan=False) for part in value]
    if depth and isinstance(value, dict | list):
        parts = value.values() if isinstance(value, dict) else value
        inner = [
            _lines(part, depth - 1, indent + "  ") if isinstance(part, dict | list) and part
            else json.dumps(part, allow_nan=False)
            for part in parts
        ]  # fmt: skip
    elif isinstance(value, dict):
        inner = [json.dumps(part, allow_nan=False) for part in value.values()]
    if isinstance(value, dict):
        inner = [f"{json.dumps(k)}: {text}" for k, text in zip(value, inner, strict=True)]
    ends = "{}" if isinstance(value, dict) else "[]"
    return f"{ends[0]}\n{indent}" + f",\n{indent}".join(inner) + f"\n{indent[2:]}{ends[1]}"


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

    Raises
    ------
    ValueError : an analysis has no gains to write.
    """
    if design.gains is None or (design.law or design.output_law) is None:
        raise ValueError(
            f"plant {design.plant.name!r} has no inputs, so there are no gains to write"
        )
    body = PlantGainFile if design.output_law is None else OutputGainFile
    return validated(design.document, body)


def plant_gain_file_schema(*, outputs: bool = False) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a plant's ``gains.json``.

    Parameters
    ----------
    outputs : of a law that has measured outputs in the place of states.
    """
    body = OutputGainFile if outputs else PlantGainFile
    return file_schema(body, "takagi gain file of a plant")


class SetpointEntry(Strict):
    """The set-points that the law takes at run time: from these to the rated ones."""

    lowest_speed: float = Field(gt=0, description="[rad/s]")
    lowest_torque: float = Field(gt=0, description="[N m]")
    power_per_torque: float = Field(gt=0, description="electrical power / (torque rotor speed)")
    speed_effort: Numbers = Field(description="effort per change of the reference speed [1/s]")


class CoherentLawTables(Strict):
    """The effort-sharing law: tables over the schedule wind, linear between the nodes."""

    name: Literal["coherent"]
    wind: Numbers = Field(min_length=2, description="nodes [m/s], increasing")
    rotor_speed: Numbers = Field(description="reference speed omega* at the nodes [rad/s]")
    trim_effort: Numbers = Field(description="q* at the nodes [rad/s^2]")
    effectiveness: Numbers = Field(description="assumed pitch effectiveness b [rad/s^2 per rad]")
    effectiveness_limit: Numbers = Field(description="largest considered [rad/s^2 per rad]")
    overlap: float = Field(gt=0, description="eps of the effort ramp [rad/s^2]")
    proportional: Numbers = Field(description="gamma at the nodes [1/s]")
    integral_rate: Numbers = Field(description="nu, constant between two nodes [1/s]")
    rated_torque: float = Field(gt=0, description="[N m]")
    effort_torque: float = Field(gt=0, description="J / n_g, torque per effort [N m s^2/rad]")
    pitch_min: float
    pitch_max: float
    wind_filter: float = Field(ge=0, description="tau_f [s]; 0 passes the estimate through")
    integral_limit: float = Field(gt=0, description="largest |x| [rad/s]")
    setpoints: SetpointEntry | None = Field(default=None, description="None for none")

    @model_validator(mode="after")
    def _one_number_per_node(self) -> CoherentLawTables:
        count = len(self.wind)
        if any(b <= a for a, b in zip(self.wind, self.wind[1:], strict=False)):
            raise ValueError("law.wind: the nodes must increase")
        columns = ("rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
        needed = dict.fromkeys((*columns, "proportional"), count) | {"integral_rate": count - 1}
        for name, length in needed.items():
            if len(getattr(self, name)) != length:
                stated = len(getattr(self, name))
                raise ValueError(f"law.{name} has {stated} numbers for {count} winds; {length} fit")
        return self


class PaperLawTables(BaseModel):
    """One of the published laws, as its certificate states it."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)

    name: Literal["paper"]


class Columns(Strict):
    """A table by columns."""

    wind: Numbers
    rotor_speed: Numbers
    pitch: Numbers
    torque: Numbers
    region: list[str]


class RampEntry(Strict):
    """The ramp psi that shares an effort between torque and pitch."""

    overlap: float
    formula: list[str]


class ObserverEntry(Strict):
    """The wind observer: two gains on the speed error, and where the estimate is held."""

    l1: float
    l2: float
    decay_rate: float
    wind_limits: Numbers = Field(min_length=2, max_length=2)
    equations: list[str]


class TorsionFilterEntry(Strict):
    """A band-stop, (s^2 + 2 p w s + w^2) / (s + w)^2, on the measured speed."""

    frequency: float = Field(gt=0, description="w [rad/s]")
    passed: float = Field(ge=0, le=1, description="p, the share that passes at w [-]")


class MeasurementEntry(Strict):
    """What is done to the measured speed before observer and law read it."""

    speed_filter: float = Field(gt=0, description="corner of the one-pole low-pass [rad/s]")
    torsion_filter: TorsionFilterEntry | None = Field(
        default=None, description="a band-stop before the low-pass; none where it is left out"
    )


class RotorEntry(Strict):
    """What observer and premises need of the rotor: T_r = torque_constant v^2 c_Q."""

    torque_constant: float
    radius: float
    rotor_inertia: float
    generator_inertia: float
    gear_ratio: float
    inertia: float = Field(description="J on the low-speed side [kg m^2]")
    torque_coefficient: SplineEntry


class StartEntry(Strict):
    """Integrals to start from, over wind."""

    wind: Numbers
    integrals: list[Numbers]


class WindClassEntry(Strict):
    """The certified wind class, one entry per wind cell."""

    cells: list[Numbers]
    proved: list[bool]
    wind_error: Numbers
    wind_rate: Numbers
    decay_rate: Numbers


class TurbineCertificateEntry(CertificateEntry):
    """The same with the figures of the turbine's loop."""

    decay_rate: float | None
    overspeed: float | None
    wind_class: WindClassEntry | None


class GainFile(Envelope):
    """The whole file."""

    turbine: str
    law: Annotated[CoherentLawTables | PaperLawTables, Field(discriminator="name")]
    states: list[str]
    schedule: dict[str, str]
    execution: dict[str, str] = Field(description="one sample of the law, in words")
    ramp: RampEntry | None
    start: StartEntry | None
    trim: Columns
    limits: dict[str, Numbers | float]
    measurement: MeasurementEntry | None = None
    observer: ObserverEntry
    rotor: RotorEntry
    certificate: TurbineCertificateEntry


def gain_file(design: TurbineDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, see ``envelope.validated``."""
    return validated(design.document, GainFile)


def gain_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a turbine's ``gains.json``."""
    return file_schema(GainFile, "takagi gain file")
