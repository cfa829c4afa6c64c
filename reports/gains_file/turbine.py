r"""The gain file of a turbine: everything a controller needs, and what is proved about it.

``law`` is, number by number, the object inside the certificate, and every other member follows
from the certificate, so that ``takagi check certificate.json --gains gains.json`` compares the
whole file.  What is proved is about these decimals.  The unit of every column is in
``units``; angles in rad, torque on the high-speed shaft.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from takagi.reports.gains_file.envelope import (
    CertificateEntry,
    Envelope,
    Numbers,
    SplineEntry,
    Strict,
    file_schema,
    validated,
)

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign


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
