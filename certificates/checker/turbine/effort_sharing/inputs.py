"""The exact inputs of a claim about the effort-sharing loop: plant, law, box, uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import (
    member,
    number,
    numbers,
    positive,
    read_matrix,
    text,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.rotor import Plant

MOST_WINDS = 2000
NAME = "coherent"  # of the effort-sharing law in a file
# Numbers that differ by a larger share of their size are two floats.
FINEST = Fraction(1, 2**50)
MEMBERS: Members = {
    **plain(
        "name wind rotor_speed trim_effort effectiveness effectiveness_limit overlap proportional "
        "integral_rate rated_torque effort_torque "
        "pitch_min pitch_max wind_filter integral_limit"
    ),
    "setpoints": plain("lowest_speed lowest_torque power_per_torque speed_effort"),
}


def increasing_in_floats(values: Sequence[Fraction], where: str) -> None:
    """Refuse a row that does not increase, or not in floats: a program has no other numbers."""
    if any(b - a <= FINEST * max(abs(a), abs(b)) for a, b in pairwise(values)):
        raise CertificateError(f"{where}: the numbers must increase, also as floats")


@dataclass(frozen=True)
class SetpointRange:
    """Which set-points the law takes at run time: speed and torque from these to the rated ones.

    Attributes
    ----------
    power_per_torque : electrical power over torque times rotor speed.
    speed_effort : effort per change of the reference speed, one entry per wind node.
    """

    lowest_speed: Fraction
    lowest_torque: Fraction
    power_per_torque: Fraction
    speed_effort: list[Fraction]

    @classmethod
    def read(
        cls, gains: Any, speed: Sequence[Fraction], rated_torque: Fraction
    ) -> SetpointRange | None:
        """Return the range, None for a law without set-points; refuses one above the rated ones."""
        if "setpoints" not in gains:
            return None
        stated, where = gains["setpoints"], "gains.setpoints"
        slowest, torque, factor = (
            positive(stated, name, where)
            for name in ("lowest_speed", "lowest_torque", "power_per_torque")
        )
        if slowest > speed[-1] or torque > rated_torque:
            raise CertificateError(f"{where}: a lowest set-point is above the rated one")
        # The program holds the reference at the last speed, also at rated set-points.
        if max(speed) > speed[-1]:
            raise CertificateError(f"{where}: the last of gains.rotor_speed must be the largest")
        return cls(slowest, torque, factor, numbers(stated, "speed_effort", where, len(speed)))


@dataclass(frozen=True, kw_only=True)
class Law:
    """The law's tables, one entry per wind node; ``nu`` has one per interval."""

    wind: list[Fraction]
    speed: list[Fraction]
    effort: list[Fraction]
    effectiveness: list[Fraction]
    limit: list[Fraction]
    gamma: list[Fraction]
    nu: list[Fraction]
    overlap: Fraction
    rated_torque: Fraction
    effort_torque: Fraction
    pitch_min: Fraction
    pitch_max: Fraction
    integral_limit: Fraction
    setpoints: SetpointRange | None

    @classmethod
    def read(cls, gains: Any) -> Law:
        """Return the law.

        Refused are another law, winds that do not increase, and gains that are not positive.
        """
        # The program of a gain file follows from this name.
        if text(gains, "name", "gains") != NAME:
            raise CertificateError(f"gains.name: a claim about the law {NAME!r}")
        wind = numbers(gains, "wind", "gains")
        increasing_in_floats(wind, "gains.wind")
        count = len(wind)
        if not 2 <= count <= MOST_WINDS:
            raise CertificateError(f"gains.wind: {count} winds; 2 to {MOST_WINDS} are needed")
        speed = numbers(gains, "rotor_speed", "gains", count)
        rated_torque = positive(gains, "rated_torque", "gains")
        law = cls(
            wind=wind,
            speed=speed,
            effort=numbers(gains, "trim_effort", "gains", count),
            effectiveness=numbers(gains, "effectiveness", "gains", count),
            limit=numbers(gains, "effectiveness_limit", "gains", count),
            gamma=numbers(gains, "proportional", "gains", count),
            nu=numbers(gains, "integral_rate", "gains", count - 1),
            overlap=positive(gains, "overlap", "gains"),
            rated_torque=rated_torque,
            effort_torque=positive(gains, "effort_torque", "gains"),
            pitch_min=number(gains, "pitch_min", "gains"),
            pitch_max=number(gains, "pitch_max", "gains"),
            integral_limit=positive(gains, "integral_limit", "gains"),
            setpoints=SetpointRange.read(gains, speed, rated_torque),
        )
        if min(wind[0], *law.speed, *law.effectiveness, *law.gamma, *law.nu) <= 0:
            raise CertificateError("gains: winds, speeds, gains, effectiveness must be positive")
        return law

    def slope(self, column: list[Fraction], k: int) -> Fraction:
        """Return the slope of a column over wind in interval k."""
        return (column[k + 1] - column[k]) / (self.wind[k + 1] - self.wind[k])


@dataclass(frozen=True)
class Box:
    """The region around the trim that is enclosed."""

    speed_error: Fraction
    effort_lag: Fraction
    speed_signal: Fraction
    wind_share: Fraction

    @classmethod
    def read(cls, claim: Any, where: str) -> Box:
        """Return the box; refuses bounds that are not positive and a wind share of 1 or more."""
        box = member(claim, "box", where)
        names = ("speed_error", "effort_lag", "speed_signal", "wind_share")
        values = [number(box, name, f"{where}.box") for name in names]
        if min(values) <= 0 or values[3] >= 1:
            raise CertificateError(f"{where}.box: positive bounds, and a wind share below 1")
        return cls(*values)


@dataclass(frozen=True)
class Uncertainty:
    """True over nominal inertia, whether pitch may work as with a frozen wake, true over table c_P.

    A file without ``power_coefficient`` means the c_P of the table.
    """

    inertia: tuple[Fraction, Fraction]
    frozen_wake: bool
    power: tuple[Fraction, Fraction]

    @classmethod
    def read(cls, claim: Any, where: str) -> Uncertainty:
        """Return the uncertainty; refuses an interval that is empty or reaches zero."""
        stated, place = member(claim, "uncertainty", where), f"{where}.uncertainty"
        low, high = numbers(stated, "inertia", place, 2)
        if not 0 < low <= high:
            raise CertificateError(f"{place}.inertia: 0 < low <= high is needed")
        frozen = member(stated, "frozen_wake", place)
        if not isinstance(frozen, bool):
            raise CertificateError(f"{place}.frozen_wake: true or false is needed")
        least = most = Fraction(1)
        if "power_coefficient" in stated:
            least, most = numbers(stated, "power_coefficient", place, 2)
        if not 0 < least <= 1 <= most:
            raise CertificateError(f"{place}.power_coefficient: 0 < low <= 1 <= high is needed")
        return cls((low, high), frozen, (least, most))

    @property
    def kappa(self) -> tuple[Fraction, Fraction]:
        """Nominal over true inertia: what every torque is multiplied by."""
        return 1 / self.inertia[1], 1 / self.inertia[0]


@dataclass(frozen=True)
class Settling:
    """A second quadratic function, with its proved decay rate at every wind."""

    P: Matrix
    decay_rate: Fraction

    @classmethod
    def read(cls, claim: Any, where: str) -> Settling:
        """Return it; refuses another size than 3 by 3 and a negative rate."""
        stated, place = member(claim, "settling", where), f"{where}.settling"
        P, rate = read_matrix(stated, "P", place, (3, 3)), number(stated, "decay_rate", place)
        if rate < 0:
            raise CertificateError(f"{place}.decay_rate: a rate >= 0 is needed")
        return cls(P, rate)


@dataclass(frozen=True)
class Subject:
    """The exact inputs of one claim."""

    plant: Plant
    law: Law
    box: Box
    uncertainty: Uncertainty

    @classmethod
    def read(cls, claim: Any, model: Any, gains: Any, where: str) -> Subject:
        """Return it; refuses a law that has other pitch limits than the plant."""
        plant, law = Plant.read(model), Law.read(gains)
        if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        return cls(plant, law, Box.read(claim, where), Uncertainty.read(claim, where))
