"""What a gain file may contain: the pydantic models behind ``gains.json`` and its JSON Schema.

Every column stands beside its unit in ``units``; angles in rad, torque on the high-speed shaft.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

__all__ = [
    "CoherentLawTables",
    "Columns",
    "GainFile",
    "gain_file_schema",
]

Numbers: TypeAlias = list[float]


class _Strict(BaseModel):
    """Unknown fields are refused; numbers must be finite; nothing is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class CoherentLawTables(_Strict):
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
    inertia_feedforward: Numbers = Field(
        description="f, constant between two nodes [rad/s per m/s]: f v_s' is fed forward to torque"
    )
    feedforward_limit: Numbers = Field(
        description="g, constant between two nodes [rad/s^2]: f v_s' is held within +-g"
    )
    pitch_lead: float = Field(ge=0, description="tau_lead [s]")
    rated_torque: float = Field(gt=0, description="[N m]")
    effort_torque: float = Field(gt=0, description="J / n_g, torque per effort [N m s^2/rad]")
    pitch_min: float
    pitch_max: float
    wind_filter: float = Field(ge=0, description="tau_f [s]; 0 passes the estimate through")
    integral_limit: float = Field(gt=0, description="largest |x| [rad/s]")

    @model_validator(mode="after")
    def _one_number_per_node(self) -> CoherentLawTables:
        count = len(self.wind)
        if any(b <= a for a, b in zip(self.wind, self.wind[1:], strict=False)):
            raise ValueError("law.wind: the nodes must increase")
        columns = ("rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
        between = ("integral_rate", "inertia_feedforward", "feedforward_limit")
        needed = dict.fromkeys((*columns, "proportional"), count)
        needed |= dict.fromkeys(between, count - 1)
        for name, length in needed.items():
            if len(getattr(self, name)) != length:
                found = len(getattr(self, name))
                raise ValueError(f"law.{name} has {found} numbers for {count} winds; {length} fit")
        return self


class PaperLawTables(BaseModel):
    """One of the published laws, as its certificate states it."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)

    name: Literal["paper", "paper-two-integrators"]


class Columns(_Strict):
    """A table by columns."""

    wind: Numbers
    rotor_speed: Numbers
    pitch: Numbers
    torque: Numbers
    region: list[str]


class RampEntry(_Strict):
    """The ramp psi that shares an effort between torque and pitch."""

    overlap: float
    formula: list[str]


class ObserverEntry(_Strict):
    """The wind observer: two gains on the speed error, and where the estimate is held."""

    l1: float
    l2: float
    decay_rate: float
    wind_limits: Numbers = Field(min_length=2, max_length=2)
    equations: list[str]


class SplineEntry(_Strict):
    """A cubic spline: a full row of knots for each argument, and the coefficients."""

    knots: list[Numbers] = Field(min_length=1, max_length=2)
    coefficients: list[Numbers] | Numbers


class RotorEntry(_Strict):
    """What observer and premises need of the rotor: T_r = torque_constant v^2 c_Q."""

    torque_constant: float
    radius: float
    rotor_inertia: float
    generator_inertia: float
    gear_ratio: float
    inertia: float = Field(description="J on the low-speed side [kg m^2]")
    torque_coefficient: SplineEntry


class StartEntry(_Strict):
    """Integrals to start from, over wind."""

    wind: Numbers
    integrals: list[Numbers]


class ClaimEntry(_Strict):
    """One claim of the certificate and what the checker says."""

    name: str
    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    text: str


class WindClassEntry(_Strict):
    """The certified wind class, one entry per wind cell."""

    cells: list[Numbers]
    proved: list[bool]
    wind_error: Numbers
    wind_rate: Numbers
    decay_rate: Numbers


class CertificateEntry(_Strict):
    """What the certificate beside this file says about the law."""

    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    claims: list[ClaimEntry]
    decay_rate: float | None
    overspeed: float | None
    wind_class: WindClassEntry | None
    sha256: dict[str, str]


class NameEntry(_Strict):
    """Where the value of a name stands in the file."""

    value: str
    unit: str


class ReadEntry(_Strict):
    """A signal that is read at every sample."""

    name: str
    unit: str
    meaning: str


class KeepEntry(_Strict):
    """A value that is kept from one sample to the next."""

    name: str
    unit: str
    start: str
    next: str
    meaning: str


class NearEntry(_Strict):
    """What stands in the place of a step's formula where |of| <= within."""

    of: str
    within: float = Field(ge=0)
    formula: str


class RemovableEntry(NearEntry):
    """The same for a premise, with the limit where it is 0/0."""

    limit: str


class StepEntry(_Strict):
    """One assignment."""

    set: str
    unit: str
    formula: str
    meaning: str


class NearStepEntry(StepEntry):
    """One assignment with other formulas near some points."""

    near: list[RemovableEntry | NearEntry]


class SendEntry(_Strict):
    """A signal that is sent at every sample."""

    name: str
    unit: str
    formula: str
    meaning: str


class ProgramEntry(_Strict):
    """One sample of a part of the controller; ``language`` says how it is read."""

    name: str
    names: dict[str, NameEntry]
    read: list[ReadEntry]
    keep: list[KeepEntry]
    steps: list[NearStepEntry | StepEntry]
    send: list[SendEntry]


class GainFile(_Strict):
    """The whole file."""

    format: Literal["takagi-gains"]
    version: Literal[3]
    name: str
    turbine: str
    units: dict[str, str]
    law: Annotated[CoherentLawTables | PaperLawTables, Field(discriminator="name")]
    states: list[str]
    schedule: dict[str, str]
    execution: dict[str, str] = Field(description="one sample of the law, in words")
    ramp: RampEntry | None
    start: StartEntry | None
    trim: Columns
    limits: dict[str, Numbers | float]
    observer: ObserverEntry
    rotor: RotorEntry
    language: dict[str, str]
    programs: list[ProgramEntry]
    certificate: CertificateEntry


def gain_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of ``gains.json``."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi gain file",
        **GainFile.model_json_schema(),
    }
