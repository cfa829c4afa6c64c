r"""The published multi-region law of Schulte (2024), ``paper`` in files.

With e = omega - omega_ref(v_hat), the blended gains of the two regions, and one integral x_I:

    u_1 = -k^b_w e            + k^b_I x_I        torque
    u_2 = -k^c_w e - k^c_p b  + k^c_I x_I        pitch (absolute: b, not its deviation)
    (T, beta_ref) = F(omega, u_1) (u_1, u_2),    held to 0..T_rated and the pitch range
    x_I' = -e

The aggregated equation of the paper has k_I inside the bracket with a minus, the two regional laws
with a plus; the regional sign is taken.  The triple sum over rules is the same law (a test).

The equilibrium of the law, and whether that is the turbine's trim.

x_I' = 0 forces omega = omega_ref.  With f_1 = f_1(omega_ref) > 0 the pitch channel at the
equilibrium gives

    x_I = (1 + f_1 k^c_p) b / (f_1 k^c_I)                                              (1)

and one balance is left, T_r(omega_ref, b, v) = n_g T(k^b_I x_I(b)).  Below rated torque, (1) gives
a pitch angle above the trim's,

    b = f_1 / (1 + f_1 k^c_p) (k^c_I / k^b_I) u_1,                                     (2)

so torque has to be integrated much faster than pitch.  With f_1 = 0 the pitch command is zero, and
above rated wind there is no equilibrium.  A small f_1 makes (2) small too, but the ramp then adds
f_1' b / f_1 to the gain from speed to pitch at rest, which excites the tower in high wind
(docs/laws.md).

All this is floating point, for a constant wind with v_hat = v.

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, section "Fuzzy-Blending of
Control Regions"; readings in docs/laws.md.

The reference filter G_f(s) of the published laws: a low-pass on the region-dependent speed.

The reference omega_ref(v_hat) has kinks where a region ends and follows every movement of the wind
estimate.  With r the filtered reference, a published law takes e = omega - r instead:

    order 1    tau r' = omega_ref(v_hat) - r               G_f = 1 / (1 + tau s)
    order 2    r'' = w^2 (omega_ref - r) - 2 zeta w r'     G_f = w^2 / (s^2 + 2 zeta w s + w^2)

with w = 1 / tau.

G_f(0) = 1, so the filter does not change the law's equilibrium. It filters the reference speed; the
filter of the effort-sharing law acts on the wind estimate instead.  Where omega_ref is a line in
the wind (region 2) or constant (1.5, 2.5, 3) the two are the same.

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, which names the filter and
does not specify it; docs/laws.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from math import exp, isfinite, radians
from typing import ClassVar, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.laws.published.regional_schedule import (
    CouplingFilter,
    RegionalGainValues,
    RegionalSchedule,
    premise_band,
    premise_evaluators,
)
from takagi.models.ramps import Ramp
from takagi.models.splines.spline import scalar_surface
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand
from takagi.models.turbine.trim import TABLE_SHARE, TrimPoint, optimal_tip_speed_ratio, trim


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
    turbine : figures, limits and torque surface.
    coupling : the filter F.
    partial, full : the regional gains and their schedules.
    speed_setpoint : rotor speed of full load [rad/s].
    """

    turbine: Turbine
    coupling: CouplingFilter
    partial: RegionalSchedule
    full: RegionalSchedule
    speed_setpoint: float

    name: ClassVar[str] = "paper"
    state_names: ClassVar[tuple[str, ...]] = ("integral of speed deficit [rad]",)

    def __post_init__(self) -> None:
        for region in (self.partial, self.full):
            if np.any(region.k_I >= 0):
                raise ModelError(
                    f"{region.model.name}: integral gains k_I must be negative (a speed below its "
                    f"reference lowers torque and pitch); rule {int(np.argmax(region.k_I)) + 1} "
                    f"has {float(region.k_I.max()):.6g}: give k_I = -K_I of u = -K x"
                )

    def reference_speed(self, wind: float) -> float:
        """Return omega_ref(v_hat) [rad/s]; an estimate outside cut-in to cut-out is held there."""
        per_ratio = self._inside(wind) / self.turbine.rotor_radius
        ceiling = TABLE_SHARE * self.turbine.torque.x_range[1] * per_ratio
        minimum = min(self.turbine.minimum_rotor_speed, ceiling)
        optimal = optimal_tip_speed_ratio(self.turbine) * per_ratio
        return min(max(optimal, minimum), self.speed_setpoint)

    def _inside(self, wind: float) -> float:
        return min(max(wind, self.turbine.cut_in), self.turbine.cut_out)

    def initial_state(self, wind: float) -> Floats:
        """Return the integral at the law's own equilibrium, or nearest to the trim without one.

        See ``equilibrium``: that equilibrium need not be the turbine's trim.  A wind outside cut-in
        to cut-out is held there: the first of a turbulent one may be.
        """
        return np.array([equilibrium(self, self._inside(wind)).integral])

    def blended(
        self, state: ArrayLike, measurement: Measurement, *, reference: float | None = None
    ) -> BlendedCommands:
        """Return the regional and the blended commands before the limits.

        ``reference`` [rad/s] stands in for omega_ref(v_hat); None takes that.
        """
        speed, pitch, wind = measurement
        x = float(np.asarray(state, dtype=np.float64)[0])
        error = speed - (self.reference_speed(wind) if reference is None else reference)
        b, c = self.partial.gains_at(speed, pitch, wind), self.full.gains_at(speed, pitch, wind)
        torque = -b.speed * error - b.pitch * pitch + b.integral * x
        angle = -c.speed * error - c.pitch * pitch + c.integral * x
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
        """Return the derivative of the integral [rad/s]; ``reference`` as in ``blended``."""
        if reference is None:
            reference = self.reference_speed(measurement.wind_estimate)
        return np.array([reference - measurement.rotor_speed])


def published_law(
    turbine: Turbine,
    *,
    partial: RegionalSchedule,
    full: RegionalSchedule,
    coupling: CouplingFilter,
    speed_setpoint: float | None = None,
) -> PublishedLaw:
    """Return the published law of a turbine.

    Parameters
    ----------
    partial, full : gains with their schedules (``regional_schedule``).
    coupling : the filter (``coupling_filter``).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated one.

    Raises
    ------
    ModelError : k_I of the wrong sign.
    """
    setpoint = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    return PublishedLaw(turbine, coupling, partial, full, setpoint)


class SwitchedLaw(PublishedLaw):
    """The same regional gains without overlap: pitch acts from the set-point on, and not below.

    Torque is limited where it reaches the rated one.  There is no hysteresis.
    """

    __slots__ = ()
    name: ClassVar[str] = "switched"


def switched_law(law: PublishedLaw) -> SwitchedLaw:
    """Return a law with a switch in place of its coupling filter: the limit of no overlap."""
    ramp = Ramp(law.speed_setpoint, 0.0, law.coupling.speed_ramp.shape)
    coupling = replace(law.coupling, variant="saturated", speed_ramp=ramp, torque_overlap=0.0)
    return SwitchedLaw(law.turbine, coupling, law.partial, law.full, law.speed_setpoint)


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


Kind: TypeAlias = Literal["intended", "shifted", "none"]

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
    kind : "intended", the trim up to the tolerances; "shifted", elsewhere; "none".
    rotor_speed [rad/s], pitch [rad], torque [N m] : the equilibrium; NaN for "none".
    integral : the law's state there [rad]; for "none" the one that gives the trim's torque.
    trim : the turbine's trim.
    pitch_share : f_1 at the reference speed.
    """

    wind: float
    kind: Kind
    rotor_speed: float
    pitch: float
    torque: float
    integral: float
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
    from scipy.optimize import brentq

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
    integral: float,
) -> Equilibrium:
    turbine = law.turbine
    as_intended = (
        abs(speed - point.rotor_speed) <= SPEED_TOLERANCE * turbine.rated_rotor_speed
        and abs(pitch - point.pitch) <= PITCH_TOLERANCE
        and abs(torque - point.torque) <= TORQUE_TOLERANCE * turbine.rated_torque
    )
    kind: Kind = "intended" if as_intended else "shifted"
    return Equilibrium(wind, kind, speed, pitch, torque, integral, point, f_1)


def no_equilibrium(law: PublishedLaw, wind: float, point: TrimPoint, f_1: float) -> Equilibrium:
    b = law.partial.gains_at(point.rotor_speed, point.pitch, wind).integral
    return Equilibrium(wind, "none", NO_ROOT, NO_ROOT, NO_ROOT, point.torque / b, point, f_1)


def equilibrium(law: PublishedLaw, wind: float) -> Equilibrium:
    """Return where the law rests at a constant wind [m/s], estimate exact.

    Of several equilibria the one with least pitch is returned.

    Raises
    ------
    ModelError : no trim at this wind.
    """
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
    return named(law, wind, point, f_1, speed, pitch, torque(pitch), integral(pitch))


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
    return named(law, wind, point, f_1, speed, pitch, torque_of(law, command), x)


@dataclass(frozen=True, slots=True)
class ReferenceFilter:
    """G_f(s) as a value.

    Attributes
    ----------
    time_constant : tau [s].
    order : 1 or 2.
    damping : zeta of order 2 [-].

    Raises
    ------
    ModelError : a time or damping that is not positive, another order.
    """

    time_constant: float
    order: int = 1
    damping: float = 1.0

    def __post_init__(self) -> None:
        for name in ("time_constant", "damping"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ModelError(
                    f"reference filter with {name} = {value!r} was given; a positive number is "
                    "needed (for no filter take the law itself)"
                )
        if self.order not in (1, 2):
            raise ModelError(f"reference filter of order {self.order!r} was given; take 1 or 2")

    def rest(self, reference: float) -> Floats:
        """Return the state at which the output is ``reference`` [rad/s] and stays there."""
        return np.array([reference, 0.0][: self.order])

    def rate(self, state: ArrayLike, reference: float) -> Floats:
        """Return the state's derivative for an input ``reference`` [rad/s]."""
        return np.asarray(self._matrix() @ (np.asarray(state) - self.rest(reference)))

    def after(self, state: ArrayLike, reference: float, time: float) -> Floats:
        """Return the state ``time`` [s] later, the input held: exactly, by the exponential."""
        rest = self.rest(reference)
        away = np.asarray(state, dtype=np.float64) - rest
        if self.order == 1:
            return np.asarray(rest + exp(-time / self.time_constant) * away)
        return np.asarray(rest + expm(time * self._matrix()) @ away)

    def _matrix(self) -> Floats:
        w = 1 / self.time_constant
        if self.order == 1:
            return np.array([[-w]])
        return np.array([[0.0, 1.0], [-w * w, -2 * self.damping * w]])


@dataclass(frozen=True, slots=True, eq=False)
class FilteredReferenceLaw:
    """A published law with a reference filter; it can be simulated, but not certified.

    A certificate of a published law is about the law without the filter. At a constant wind both
    laws are the same once the filter has settled.

    Attributes
    ----------
    law : Schulte's law.   filter : G_f.
    """

    law: PublishedLaw
    filter: ReferenceFilter

    @property
    def name(self) -> str:
        """The law's name, with the filter's time constant."""
        return f"{self.law.name}, reference filter {self.filter.time_constant:g} s"

    @property
    def state_names(self) -> tuple[str, ...]:
        """The law's integrals, then the filter's states."""
        filter_names = ("filtered reference speed [rad/s]", "its rate [rad/s^2]")
        return (*self.law.state_names, *filter_names[: self.filter.order])

    def initial_state(self, wind: float) -> Floats:
        """Return the law's own rest state, and the filter's at the reference of this wind [m/s]."""
        rest = self.filter.rest(self.law.reference_speed(wind))
        return np.concatenate([self.law.initial_state(wind), rest])

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad], within the limits."""
        law_state, filtered = self._parts(state)
        return self.law.limited(
            self.law.blended(law_state, measurement, reference=float(filtered[0]))
        )

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> Floats:
        """Return the rates of the integrals and of the filter."""
        law_state, filtered = self._parts(state)
        reference = self.law.reference_speed(measurement.wind_estimate)
        integrals = self.law.state_rate(law_state, measurement, reference=float(filtered[0]))
        return np.concatenate([integrals, self.filter.rate(filtered, reference)])

    def sample(
        self, state: ArrayLike, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        """Return the command, and the state ``time`` [s] later: the filter exactly, else Euler."""
        law_state, filtered = self._parts(state)
        reference = self.law.reference_speed(measurement.wind_estimate)
        rate = self.law.state_rate(law_state, measurement, reference=float(filtered[0]))
        later = np.concatenate(
            [law_state + time * rate, self.filter.after(filtered, reference, time)]
        )
        return self.command(state, measurement), later

    def _parts(self, state: ArrayLike) -> tuple[Floats, Floats]:
        full_state = np.asarray(state, dtype=np.float64)
        return full_state[: -self.filter.order], full_state[-self.filter.order :]
