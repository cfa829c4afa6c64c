"""What a claim of kind ``turbulence-speed`` states: wind, filters, inertia, speeds, probability."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import member, number, numbers, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Span,
    other_than_the_controller,
)


@dataclass(frozen=True)
class Turbulence:
    """Mean wind and standard deviation of the wind [m/s], and rms of its rate [m/s^2]."""

    mean: Fraction
    deviation: Fraction
    rate: Fraction

    @classmethod
    def read(cls, claim: Any, where: str) -> Turbulence:
        """Return it; refuses numbers that are not positive."""
        stated, place = member(claim, "wind", where), f"{where}.wind"
        return cls(*(positive(stated, name, place) for name in cls.__dataclass_fields__))


@dataclass(frozen=True, kw_only=True)
class StatedSpeed:
    """The claim and the parts of the file that it is about.

    Attributes
    ----------
    wind, highest : the turbulence, and the wind that it seldom reaches [m/s].
    least_estimate : the claim ends where the wind estimate falls below this [m/s].
    speed, window : the speed that the rotor does not reach, and how far below it the torque's past
        is followed [rad/s].
    corner, stop : of the low-pass of the measured speed [rad/s]; frequency [rad/s] and passed share
        of the band-stop, where there is one.
    wind_filter : tau_f [s].
    torque_rate : the gain file's limit of the torque's rate, high-speed shaft [N m/s].
    inertia : true over nominal.
    excess : by which the rotor's torque over J may exceed the table's [rad/s^2], 0 or more.
    horizon, probability : T [s] and p.
    """

    plant: Plant
    law: Law
    wind: Turbulence
    highest: Fraction
    least_estimate: Fraction
    speed: Fraction
    window: Fraction
    corner: Fraction
    stop: Span | None
    wind_filter: Fraction
    torque_rate: Fraction
    inertia: Span
    excess: Fraction
    horizon: Fraction
    probability: Fraction

    @classmethod
    def read(cls, claim: Any, data: Any, where: str) -> StatedSpeed:
        """Return it; ``data`` is the whole file.

        Raises
        ------
        CertificateError : a part is missing or is not what it has to be; also a filter that is not
            that of the certificate's ``controller``.
        """
        model, gains = member(data, "model", "certificate"), member(data, "gains", "certificate")
        plant, law = Plant.read(model), Law.read(gains)
        if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        if other := other_than_the_controller(claim, data, where, ("measurement",)):
            raise CertificateError(f"{where}.{other}")
        corner, stop = _filters(claim, where)
        given, place = member(claim, "uncertainty", where), f"{where}.uncertainty"
        low, high = numbers(given, "inertia", place, 2)
        if not 0 < low <= high:
            raise CertificateError(f"{place}.inertia: 0 < low <= high is needed")
        excess = number(given, "torque_excess", place)
        if excess < 0:
            raise CertificateError(f"{place}.torque_excess: a number from 0 on is needed")
        names = ("highest_wind", "least_estimate", "speed", "window")
        highest, least, speed, window = (positive(claim, name, where) for name in names)
        if not window < speed:
            raise CertificateError(f"{where}.window: a number below the speed is needed")
        probability = positive(claim, "probability", where)
        if not probability < 1:
            raise CertificateError(f"{where}.probability: a number between 0 and 1 is needed")
        return cls(
            plant=plant,
            law=law,
            wind=Turbulence.read(claim, where),
            highest=highest,
            least_estimate=least,
            speed=speed,
            window=window,
            corner=corner,
            stop=stop,
            wind_filter=positive(gains, "wind_filter", "gains"),
            torque_rate=positive(model, "torque_rate_limit", "model"),
            inertia=(low, high),
            excess=excess,
            horizon=positive(claim, "horizon", where),
            probability=probability,
        )

    @property
    def kappa(self) -> Fraction:
        """The greatest nominal over true inertia."""
        return 1 / self.inertia[0]

    @property
    def delay(self) -> Fraction:
        """The integral of one less the step response of the filters of the measured speed [s]."""
        found = 1 / self.corner
        if self.stop:
            found += 2 * (1 - self.stop[1]) / self.stop[0]
        return found


def _filters(claim: Any, where: str) -> tuple[Fraction, Span | None]:
    filters, place = member(claim, "measurement", where), f"{where}.measurement"
    corner, stop = positive(filters, "speed_filter", place), None
    if "torsion_filter" in filters:
        stopped, place = filters["torsion_filter"], f"{place}.torsion_filter"
        stop = positive(stopped, "frequency", place), number(stopped, "passed", place)
        if not 0 <= stop[1] <= 1:
            raise CertificateError(f"{place}.passed: a share from 0 to 1 is needed")
    return corner, stop
