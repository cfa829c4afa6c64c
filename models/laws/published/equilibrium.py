r"""The equilibrium of the published law, and whether that is the turbine's trim.

Shared integrator.  x_I' = 0 forces omega = omega_ref.  With f_1 = f_1(omega_ref) > 0 the pitch
channel at the equilibrium gives

    x_I = (1 + f_1 k^c_p) b / (f_1 k^c_I)                                              (1)

and one balance is left, T_r(omega_ref, b, v) = n_g T(k^b_I x_I(b)).  Below rated torque, (1) gives
a pitch angle above the trim's, in proportion to f_1. With f_1 = 0 the pitch command is zero, and
above rated wind there is no equilibrium. If f_1(omega_rated) is a few thousandths, the equilibrium
is near the trim in both regions, but by (1) the integral must then change about 1/f_1 times as
much. So no placement of the ramp suits regions 2.5 and 3 at once.

Two integrators. At rest each one balances the speed error against its channel's tracking term:

    e = (u_1 - T)/(tau |k^b_I|) = (u_2 - beta_ref)/(tau |k^c_I|),

so both channels have the same small overspeed e, which follows from the torque balance (a small
underspeed if ``sector`` raises torque above its command). If f_1(omega_ref) = 1, both are at rest
with e = 0 and any split of torque and pitch: there is a continuum of equilibria.

All this is floating point, for a constant wind with v_hat = v.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import radians
from typing import Literal, Protocol, TypeAlias

import numpy as np
from scipy.optimize import brentq

from takagi.models.laws.published.regional_schedule import CouplingFilter, RegionalSchedule
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
    grid = np.linspace(low, high, GRID)
    values = [function(float(x)) for x in grid]
    for k in range(GRID - 1):
        if values[k] == 0.0:
            return float(grid[k])
        if values[k] * values[k + 1] < 0:
            return float(brentq(function, grid[k], grid[k + 1], xtol=1e-13))
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
    as_intended = (
        abs(speed - point.rotor_speed) <= SPEED_TOLERANCE * turbine.rated_rotor_speed
        and abs(pitch - point.pitch) <= PITCH_TOLERANCE
        and abs(torque - point.torque) <= TORQUE_TOLERANCE * turbine.rated_torque
    )
    kind: Kind = "intended" if as_intended else "shifted"
    return Equilibrium(wind, kind, speed, pitch, torque, integrals, point, f_1)


def no_equilibrium(law: LawFigures, wind: float, point: TrimPoint, f_1: float) -> Equilibrium:
    b = law.partial.gains_at(point.rotor_speed, point.pitch, wind).integral
    c = law.full.gains_at(point.rotor_speed, point.pitch, wind)
    integrals: tuple[float, ...] = (point.torque / b,)
    if law.name != "paper":
        integrals += ((1 + c.pitch) * point.pitch / c.integral,)
    return Equilibrium(wind, "none", NO_ROOT, NO_ROOT, NO_ROOT, integrals, point, f_1)


def one_integrator_equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), trim_at(law, wind)
    f_1 = law.coupling.speed_ramp.at(speed)
    rotor, lowest = rotor_torque_over_pitch(law, speed, wind), law.turbine.pitch_min
    if f_1 == 0.0:
        return _torque_alone(law, wind, point, max(lowest, 0.0), f_1)

    def integral(pitch: float) -> float:
        gains = law.full.gains_at(speed, pitch, wind)
        return (1 / f_1 + gains.pitch) * pitch / gains.integral

    def torque(pitch: float) -> float:
        gain = law.partial.gains_at(speed, pitch, wind).integral
        return torque_of(law, gain * integral(pitch))

    def balance(pitch: float) -> float:
        return rotor(pitch) - torque(pitch)

    if balance(lowest) <= 0:
        return _torque_alone(law, wind, point, lowest, f_1)
    pitch = first_root(balance, lowest, highest_pitch(law))
    if np.isnan(pitch):
        return no_equilibrium(law, wind, point, f_1)
    return named(law, wind, point, f_1, speed, pitch, torque(pitch), (integral(pitch),))


def _torque_alone(
    law: LawFigures, wind: float, point: TrimPoint, pitch: float, f_1: float
) -> Equilibrium:
    """Return the equilibrium at a fixed pitch, or none where torque does not suffice."""
    speed = law.reference_speed(wind)
    needed = rotor_torque_over_pitch(law, speed, wind)(pitch)
    top = law.turbine.rated_torque + law.coupling.torque_overlap
    command = first_root(lambda u: needed - torque_of(law, u), 0.0, top)
    if np.isnan(command):
        return no_equilibrium(law, wind, point, f_1)
    x = command / law.partial.gains_at(speed, pitch, wind).integral
    return named(law, wind, point, f_1, speed, pitch, torque_of(law, command), (x,))


CONTRACTIONS = 12


def two_integrators_equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), trim_at(law, wind)
    f_1, lowest = law.coupling.speed_ramp.at(speed), law.turbine.pitch_min
    passing, rotor = passing_torque(law), rotor_torque_over_pitch(law, speed, wind)
    if point.torque <= passing and point.pitch == lowest:
        kind: Kind = "intended" if f_1 < 1.0 else "continuum"
        return _resting(law, point, f_1, kind, 0.0, point.pitch, point.torque)
    if f_1 >= 1.0:
        level = held_torque(law) if rotor(lowest) >= held_torque(law) else passing
        pitch = first_root(lambda b: rotor(b) - level, lowest, highest_pitch(law))
        return _resting(law, point, f_1, "continuum", 0.0, pitch, level)

    def balance(error: float) -> float:
        pitch, command = _carried(law, speed + error, wind, error)
        return rotor_torque_over_pitch(law, speed + error, wind)(pitch) - torque_of(law, command)

    if balance(0.0) < 0:
        return _raised(law, point, f_1)
    # Beyond the ramp's end f_1 = 1 and the tracking term vanishes, so no overspeed can be at rest;
    # the pitch grows without bound there.
    last = law.coupling.speed_ramp.end - speed
    # At the end itself the pitch is infinite, so the search stops just before it.
    error = first_root(balance, 0.0, last * (1 - 1e-9))
    if np.isnan(error):
        return no_equilibrium(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error, *_carried(law, speed + error, wind, error))


def _raised(law: LawFigures, point: TrimPoint, f_1: float) -> Equilibrium:
    """Return the equilibrium below the reference speed, where ``sector`` gives more than u_1."""
    wind, speed = point.wind, law.reference_speed(point.wind)

    def error_at(command: float) -> float:
        excess, error = (command - torque_of(law, command)) / float(law.tracking_time or 0.0), 0.0
        # The gain hardly depends on the error, so this contraction settles at once.
        for _ in range(CONTRACTIONS):
            gains = law.partial.gains_at(speed + error, point.pitch, wind)
            error = excess / abs(gains.integral)
        return error

    def balance(command: float) -> float:
        rotor = rotor_torque_over_pitch(law, speed + error_at(command), wind)
        return rotor(law.turbine.pitch_min) - torque_of(law, command)

    command = first_root(balance, passing_torque(law), law.coupling.rated_torque)
    if np.isnan(command):
        return no_equilibrium(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error_at(command), law.turbine.pitch_min, command)


def _carried(law: LawFigures, speed: float, wind: float, error: float) -> tuple[float, float]:
    """Return (pitch, torque command u_1) at which both integrators rest with this error."""
    tau, highest = float(law.tracking_time or 0.0), highest_pitch(law)
    f_1 = law.coupling.speed_ramp.at(speed)
    lever = f_1 * tau * error / (1.0 - f_1) if f_1 < 1.0 else np.inf

    def pitch_gap(pitch: float) -> float:
        return pitch - lever * abs(law.full.gains_at(speed, pitch, wind).integral)

    lowest = law.turbine.pitch_min
    if pitch_gap(lowest) >= 0:
        pitch = lowest
    else:
        pitch = highest if pitch_gap(highest) <= 0 else brentq(pitch_gap, lowest, highest)
    excess = tau * error * abs(law.partial.gains_at(speed, pitch, wind).integral)
    low = held_torque(law)
    high = law.turbine.rated_torque + law.coupling.torque_overlap + excess
    if excess <= 0:
        return float(pitch), low
    return float(pitch), float(brentq(lambda u: u - torque_of(law, u) - excess, low, high))


def _resting(
    law: LawFigures,
    point: TrimPoint,
    f_1: float,
    kind: Kind | None,
    error: float,
    pitch: float,
    command: float,
) -> Equilibrium:
    """Return the equilibrium of the two integrators with the integrals that give it."""
    speed = law.reference_speed(point.wind) + error
    b = law.partial.gains_at(speed, pitch, point.wind)
    c = law.full.gains_at(speed, pitch, point.wind)
    here = law.coupling.speed_ramp.at(speed)
    pitching = here > 0 and error >= 0
    angle = pitch / here if pitching else float(law.tracking_time or 0.0) * error * abs(c.integral)
    torque = torque_of(law, command)
    integrals = (
        (command + b.speed * error + b.pitch * pitch) / b.integral,
        (angle + c.speed * error + c.pitch * pitch) / c.integral,
    )
    named_point = named(law, point.wind, point, f_1, speed, pitch, torque, integrals)
    if kind is None:
        return named_point
    return Equilibrium(point.wind, kind, speed, pitch, torque, integrals, point, f_1)


def equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    """Return where the law rests at a constant wind [m/s], estimate exact.

    Of several equilibria of the shared integrator the one with least pitch is returned.

    Raises
    ------
    ModelError : no trim at this wind.
    """
    return (
        one_integrator_equilibrium(law, wind)
        if law.name == "paper"
        else two_integrators_equilibrium(law, wind)
    )
