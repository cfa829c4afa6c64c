"""The box of one cell of the loop about the trim at the schedule wind."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.turbine.running_loop.inputs import positive_sides


@dataclass(frozen=True)
class ScheduleSides:
    """Bounds of the deviations from the trim at the schedule wind, all positive.

    Attributes
    ----------
    speed, measured : of the rotor's speed and of the filtered one [rad/s].
    pitch : of the pitch [rad].
    signal : of omega_m - omega* - x [rad/s].
    wind, estimate : of the wind and of the observer's wind, both less the schedule wind [m/s].
    measured_rate : of the filtered speed's rate [rad/s^2].
    innovation : of the filtered speed less the observer's [rad/s].
    drive : of the pitch that is sent less the pitch [rad].
    """

    speed: Fraction
    measured: Fraction
    pitch: Fraction
    signal: Fraction
    wind: Fraction
    estimate: Fraction
    measured_rate: Fraction
    innovation: Fraction
    drive: Fraction

    @classmethod
    def read(cls, cell: Any, where: str) -> ScheduleSides:
        """Return the box; refuses a side that is not positive."""
        return cls(*positive_sides(cell, cls.__dataclass_fields__, where))
