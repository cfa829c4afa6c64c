"""An equilibrium of the published law as a value, and helper functions to find one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import radians
from typing import Literal, Protocol, TypeAlias

import numpy as np
from scipy.optimize import brentq

from takagi.models.laws.published.coupling_filter import CouplingFilter
from takagi.models.laws.published.regional_schedule import RegionalSchedule
from takagi.models.splines.scalar_surface import scalar_surface
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint, trim

Kind: TypeAlias = Literal["intended", "shifted", "continuum", "none"]

# An equilibrium is "intended" if it differs from the trim by less than these, which are far below
# the accuracy of a turbine.
SPEED_TOLERANCE = 1e-3  # of rated speed
PITCH_TOLERANCE = radians(0.1)
TORQUE_TOLERANCE = 1e-3  # of rated torque
GRID = 60
NO_ROOT = float("nan")


class LawFigures(Protocol):
    """The part of ``PublishedLaw`` that the search for an equilibrium uses."""

    @property
    def name(self) -> str: ...

    @property
    def turbine(self) -> Turbine: ...

    @property
    def coupling(self) -> CouplingFilter: ...

    @property
    def partial(self) -> RegionalSchedule: ...

    @property
    def full(self) -> RegionalSchedule: ...

    @property
    def tracking_time(self) -> float | None: ...

    @property
    def speed_setpoint(self) -> float: ...

    def reference_speed(self, wind: float) -> float: ...


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """The equilibrium of a law at one wind, and the trim that it was meant to hold.

    Attributes
    ----------
    wind : [m/s].
    kind : "intended", the trim up to the tolerances; "shifted", elsewhere; "continuum", the trim
        is one of infinitely many (the one with most torque is given); "none".
    rotor_speed [rad/s], pitch [rad], torque [N m] : the equilibrium; NaN for "none".
    integrals : the law's state there, [rad]; for "none" the one that gives the trim's torque.
    trim : the turbine's trim.
    pitch_share : f_1 at the reference speed.
    """

    wind: float
    kind: Kind
    rotor_speed: float
    pitch: float
    torque: float
    integrals: tuple[float, ...]
    trim: TrimPoint
    pitch_share: float

    @property
    def speed_offset(self) -> float:
        """Rotor speed minus the trim's [rad/s]."""
        return self.rotor_speed - self.trim.rotor_speed

    @property
    def pitch_offset(self) -> float:
        """Pitch minus the trim's [rad]."""
        return self.pitch - self.trim.pitch

    @property
    def power_ratio(self) -> float:
        """Speed times torque over that of the trim [-]."""
        return self.rotor_speed * self.torque / (self.trim.rotor_speed * self.trim.torque)


def torque_of(law: LawFigures, command: float) -> float:
    """Return the torque that a torque command u_1 becomes: f_2 u_1 within 0..T_rated [N m]."""
    f_2, _ = law.coupling.factors_at(law.speed_setpoint, command)
    return min(max(f_2 * command, 0.0), law.turbine.rated_torque)


def passing_torque(law: LawFigures) -> float:
    """Return the largest torque command that passes unchanged."""
    coupling = law.coupling
    if coupling.variant == "sector":
        return coupling.minimum_torque - coupling.torque_overlap
    return coupling.rated_torque - coupling.torque_overlap / 2


def held_torque(law: LawFigures) -> float:
    """Return the largest torque command that is carried out as it is: rated, or near it."""
    if law.coupling.variant == "sector":
        return law.coupling.rated_torque
    return passing_torque(law)


def rotor_torque_over_pitch(law: LawFigures, speed: float, wind: float) -> Callable[[float], float]:
    """Return the rotor torque over pitch, as torque on the high-speed shaft [N m]."""
    table, turbine = scalar_surface(law.turbine.torque), law.turbine
    scale = turbine.torque_constant * wind**2 / turbine.gear_ratio
    return lambda pitch: scale * table(speed * turbine.rotor_radius / wind, pitch)


def trim_at(law: LawFigures, wind: float) -> TrimPoint:
    setpoint = None if law.speed_setpoint == law.turbine.rated_rotor_speed else law.speed_setpoint
    return trim(law.turbine, wind, speed_setpoint=setpoint)


def highest_pitch(law: LawFigures) -> float:
    return min(law.turbine.pitch_max, law.turbine.torque.y_range[1])


def first_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the first zero on a grid from low to high, refined; NaN without a sign change."""
    places = np.linspace(low, high, GRID)
    values = [function(float(x)) for x in places]
    for k in range(GRID - 1):
        if values[k] == 0.0:
            return float(places[k])
        if values[k] * values[k + 1] < 0:
            return float(brentq(function, places[k], places[k + 1], xtol=1e-13))
    return NO_ROOT


def named(
    law: LawFigures,
    wind: float,
    point: TrimPoint,
    f_1: float,
    speed: float,
    pitch: float,
    torque: float,
    integrals: tuple[float, ...],
) -> Equilibrium:
    turbine = law.turbine
    near = (
        abs(speed - point.rotor_speed) <= SPEED_TOLERANCE * turbine.rated_rotor_speed
        and abs(pitch - point.pitch) <= PITCH_TOLERANCE
        and abs(torque - point.torque) <= TORQUE_TOLERANCE * turbine.rated_torque
    )
    kind: Kind = "intended" if near else "shifted"
    return Equilibrium(wind, kind, speed, pitch, torque, integrals, point, f_1)


def no_equilibrium(law: LawFigures, wind: float, point: TrimPoint, f_1: float) -> Equilibrium:
    b = law.partial.gains_at(point.rotor_speed, point.pitch, wind).integral
    c = law.full.gains_at(point.rotor_speed, point.pitch, wind)
    integrals: tuple[float, ...] = (point.torque / b,)
    if law.name != "paper":
        integrals += ((1 + c.pitch) * point.pitch / c.integral,)
    return Equilibrium(wind, "none", NO_ROOT, NO_ROOT, NO_ROOT, integrals, point, f_1)
