r"""The published multi-region law, read literally, and its nearest working reading.

With e = omega - omega_ref(v_hat), the blended gains of the two regions, and x_b, x_c integrals:

    u_1 = -k^b_w e            + k^b_I x_b        torque
    u_2 = -k^c_w e - k^c_p b  + k^c_I x_c        pitch (absolute: b, not its deviation)
    (T, beta_ref) = F(omega, u_1) (u_1, u_2),    held to 0..T_rated and the pitch range

``paper``                   one integrator: x_b = x_c = x_I, x_I' = -e.
``paper-two-integrators``   one per region, each tracking the command that its channel delivers:
                            x_b' = -e + (T - u_1)/(tau k^b_I),
                            x_c' = -e + (beta_ref - u_2)/(tau k^c_I).

The aggregated equation of the paper has k_I inside the bracket with a minus, the two regional laws
with a plus; the regional sign is taken.  The triple sum over rules is the same law (a test).

The equilibrium of the law, and whether that is the turbine's trim.

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

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, section "Fuzzy-Blending of
Control Regions"; readings in docs/laws.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import radians
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.laws.published.regional_schedule import (
    CouplingFilter,
    RegionalGainValues,
    RegionalSchedule,
    premise_band,
    premise_evaluators,
)
from takagi.models.splines.scalar_surface import scalar_surface
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand
from takagi.models.turbine.trim import TABLE_SHARE, TrimPoint, optimal_tip_speed_ratio, trim

PublishedLawName: TypeAlias = Literal["paper", "paper-two-integrators"]


class BlendedCommands(NamedTuple):
    """Intermediate values of the law: regional commands, gains, and F times the commands."""

    torque: float
    pitch: float
    partial: RegionalGainValues
    full: RegionalGainValues
    blended_torque: float
    blended_pitch: float
    error: float


@dataclass(frozen=True, slots=True, eq=False)
class PublishedLaw:
    """The law as a value; see the module for the formulas and ``published_law`` for making one.

    Attributes
    ----------
    name : "paper" or "paper-two-integrators".
    turbine : figures, limits and torque surface.
    coupling : the filter F.
    partial, full : the regional gains and their schedules.
    tracking_time : tau [s] of the anti-windup; None with the shared integrator.
    speed_setpoint : rotor speed of full load [rad/s].
    """

    name: PublishedLawName
    turbine: Turbine
    coupling: CouplingFilter
    partial: RegionalSchedule
    full: RegionalSchedule
    tracking_time: float | None
    speed_setpoint: float

    def __post_init__(self) -> None:
        if self.name not in get_args(PublishedLawName):
            raise ModelError(
                f"law {self.name!r} was given; it is one of {', '.join(get_args(PublishedLawName))}"
                f"{did_you_mean(self.name, get_args(PublishedLawName))}"
            )
        if (self.tracking_time is None) != (self.name == "paper"):
            raise ModelError(
                f"law {self.name!r} with tracking time {self.tracking_time!r}: the shared "
                "integrator has none (None), the two integrators need one in seconds"
            )
        if self.tracking_time is not None and not self.tracking_time > 0:
            raise ModelError(f"tracking time {self.tracking_time!r} s was given; it must exceed 0")
        for region in (self.partial, self.full):
            if np.any(region.k_I >= 0):
                raise ModelError(
                    f"{region.model.name}: integral gains k_I must be negative (a speed below its "
                    f"reference lowers torque and pitch); rule {int(np.argmax(region.k_I)) + 1} "
                    f"has {float(region.k_I.max()):.6g}: give k_I = -K_I of u = -K x"
                )

    @property
    def state_names(self) -> tuple[str, ...]:
        """One integral, or one for torque and one for pitch."""
        if self.name == "paper":
            return ("integral of speed deficit [rad]",)
        return ("integral of speed deficit, torque [rad]", "integral of speed deficit, pitch [rad]")

    def reference_speed(self, wind: float) -> float:
        """Return omega_ref(v_hat) [rad/s]; an estimate outside cut-in to cut-out is held there."""
        v = min(max(wind, self.turbine.cut_in), self.turbine.cut_out)
        per_ratio = v / self.turbine.rotor_radius
        ceiling = TABLE_SHARE * self.turbine.torque.x_range[1] * per_ratio
        minimum = min(self.turbine.minimum_rotor_speed, ceiling)
        optimal = optimal_tip_speed_ratio(self.turbine) * per_ratio
        return min(max(optimal, minimum), self.speed_setpoint)

    def initial_state(self, wind: float) -> Floats:
        """Return the integrals at the law's own equilibrium, or nearest to the trim without one.

        See ``equilibrium``: that equilibrium need not be the turbine's trim.
        """
        return np.array(equilibrium(self, wind).integrals)

    def blended(
        self, state: ArrayLike, measurement: Measurement, *, reference: float | None = None
    ) -> BlendedCommands:
        """Return the regional and the blended commands before the limits.

        ``reference`` [rad/s] stands in for omega_ref(v_hat); None takes that.
        """
        speed, pitch, wind = measurement
        x = np.asarray(state, dtype=np.float64)
        x_b, x_c = float(x[0]), float(x[-1])
        error = speed - (self.reference_speed(wind) if reference is None else reference)
        b, c = self.partial.gains_at(speed, pitch, wind), self.full.gains_at(speed, pitch, wind)
        torque = -b.speed * error - b.pitch * pitch + b.integral * x_b
        angle = -c.speed * error - c.pitch * pitch + c.integral * x_c
        f_2, f_1 = self.coupling.factors_at(speed, torque)
        return BlendedCommands(torque, angle, b, c, f_2 * torque, f_1 * angle, error)

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad], within the limits."""
        return self.limited(self.blended(state, measurement))

    def limited(self, blended: BlendedCommands) -> Command:
        """Return the blended command held to 0..T_rated and to the pitch range."""
        low, high = self.turbine.pitch_min, self.turbine.pitch_max
        torque = min(max(blended.blended_torque, 0.0), self.turbine.rated_torque)
        return Command(torque, min(max(blended.blended_pitch, low), high))

    def state_rate(
        self, state: ArrayLike, measurement: Measurement, *, reference: float | None = None
    ) -> Floats:
        """Return the derivative of the integrals [rad/s]; ``reference`` as in ``blended``."""
        if reference is None:
            reference = self.reference_speed(measurement.wind_estimate)
        if self.tracking_time is None:
            return np.array([reference - measurement.rotor_speed])
        blended = self.blended(state, measurement, reference=reference)
        return self.tracking_rate(blended, self.limited(blended))

    def tracking_rate(self, blended: BlendedCommands, command: Command) -> Floats:
        """Return (x_b', x_c') of the two integrators when ``command`` is what is carried out."""
        tau = self.tracking_time
        if tau is None:
            raise ModelError(f"law {self.name!r} has one integrator and tracks nothing")
        torque_gap, pitch_gap = command.torque - blended.torque, command.pitch - blended.pitch
        return np.array(
            [
                -blended.error + torque_gap / (tau * blended.partial.integral),
                -blended.error + pitch_gap / (tau * blended.full.integral),
            ]
        )


def published_law(
    turbine: Turbine,
    *,
    partial: RegionalSchedule,
    full: RegionalSchedule,
    coupling: CouplingFilter,
    name: PublishedLawName = "paper",
    tracking_time: float = 5.0,
    speed_setpoint: float | None = None,
) -> PublishedLaw:
    """Return the published law of a turbine.

    Parameters
    ----------
    partial, full : gains with their schedules (``regional_schedule``).
    coupling : the filter (``coupling_filter``).
    name : "paper", or "paper-two-integrators".
    tracking_time : tau of the anti-windup [s]; used by the two integrators alone.
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated one.

    Raises
    ------
    ModelError : an unknown name, a tracking time that is not positive, k_I of the wrong sign.
    """
    setpoint = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    tracking = None if name == "paper" else tracking_time
    return PublishedLaw(name, turbine, coupling, partial, full, tracking, setpoint)


# Largest accepted difference between a premise by the table here and as the law computes it.
SAME = 1e-9


def schedule_band(law: PublishedLaw, schedule: RegionalSchedule) -> OperatingBand:
    """Return the trim table that a schedule's premises refer to.

    Raises
    ------
    ModelError : the schedule was made with another table.
    """
    rated = law.speed_setpoint == law.turbine.rated_rotor_speed
    band = premise_band(law.turbine, schedule.model, None if rated else law.speed_setpoint)
    low, high = float(band.wind[0]), float(band.wind[-1])
    names = [p.name for p in schedule.model.premises]
    mine = premise_evaluators(band, with_pitch="b" in names)
    for first, last in pairwise(np.linspace(low, high, 9)):
        at = (law.reference_speed(first) + 0.01, 0.1, (first + last) / 2)
        for name, theirs in zip(names, schedule.evaluators, strict=True):
            if abs(mine[name](*at) - theirs(*at)) > SAME:
                raise ModelError(
                    f"{schedule.model.name}: premise {name} of the schedule refers to another "
                    "trim table; make the schedule by regional_schedule"
                )
    return band


Kind: TypeAlias = Literal["intended", "shifted", "continuum", "none"]

# An equilibrium is "intended" if it differs from the trim by less than these, which are far below
# the accuracy of a turbine.
SPEED_TOLERANCE = 1e-3  # of rated speed
PITCH_TOLERANCE = radians(0.1)
TORQUE_TOLERANCE = 1e-3  # of rated torque
GRID = 60
NO_ROOT = float("nan")


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


def torque_of(law: PublishedLaw, command: float) -> float:
    """Return the torque that a torque command u_1 becomes: f_2 u_1 within 0..T_rated [N m]."""
    f_2, _ = law.coupling.factors_at(law.speed_setpoint, command)
    return min(max(f_2 * command, 0.0), law.turbine.rated_torque)


def passing_torque(law: PublishedLaw) -> float:
    """Return the largest torque command that passes unchanged."""
    coupling = law.coupling
    if coupling.variant == "sector":
        return coupling.minimum_torque - coupling.torque_overlap
    return coupling.rated_torque - coupling.torque_overlap / 2


def held_torque(law: PublishedLaw) -> float:
    """Return the largest torque command that is carried out as it is: rated, or near it."""
    if law.coupling.variant == "sector":
        return law.coupling.rated_torque
    return passing_torque(law)


def rotor_torque_over_pitch(
    law: PublishedLaw, speed: float, wind: float
) -> Callable[[float], float]:
    """Return the rotor torque over pitch, as torque on the high-speed shaft [N m]."""
    table, turbine = scalar_surface(law.turbine.torque), law.turbine
    scale = turbine.torque_constant * wind**2 / turbine.gear_ratio
    return lambda pitch: scale * table(speed * turbine.rotor_radius / wind, pitch)


def trim_at(law: PublishedLaw, wind: float) -> TrimPoint:
    setpoint = None if law.speed_setpoint == law.turbine.rated_rotor_speed else law.speed_setpoint
    return trim(law.turbine, wind, speed_setpoint=setpoint)


def highest_pitch(law: PublishedLaw) -> float:
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
    law: PublishedLaw,
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


def no_equilibrium(law: PublishedLaw, wind: float, point: TrimPoint, f_1: float) -> Equilibrium:
    b = law.partial.gains_at(point.rotor_speed, point.pitch, wind).integral
    c = law.full.gains_at(point.rotor_speed, point.pitch, wind)
    integrals: tuple[float, ...] = (point.torque / b,)
    if law.name != "paper":
        integrals += ((1 + c.pitch) * point.pitch / c.integral,)
    return Equilibrium(wind, "none", NO_ROOT, NO_ROOT, NO_ROOT, integrals, point, f_1)


def one_integrator_equilibrium(law: PublishedLaw, wind: float) -> Equilibrium:
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
    law: PublishedLaw, wind: float, point: TrimPoint, pitch: float, f_1: float
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


def two_integrators_equilibrium(law: PublishedLaw, wind: float) -> Equilibrium:
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


def _raised(law: PublishedLaw, point: TrimPoint, f_1: float) -> Equilibrium:
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


def _carried(law: PublishedLaw, speed: float, wind: float, error: float) -> tuple[float, float]:
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
    law: PublishedLaw,
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


def equilibrium(law: PublishedLaw, wind: float) -> Equilibrium:
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
