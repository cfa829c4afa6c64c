"""The effort-sharing law, and its loop on cells.

The effort-sharing law: one effort, shared between torque and pitch by a ramp.

With e = omega - omega*(v_f) and the states x [rad/s] and v_f [m/s],

    u  = gamma(v_f) (e - x)                    PI action, read as effort [rad/s^2]
    U  = q*(v_f) + u                           demanded effort
    T  = T_rated - (J / n_g) psi(-U)   torque delivers up to rated ...
    beta_ref = beta_min + psi(U) / b(v_f)      ... and pitch whatever lies beyond
    x'   = -nu(v_f) e
    v_f' = (v_hat - v_f) / tau_f               low-pass on the wind estimate

torque held within [0, T_rated] and pitch within its limits.  It is the proportional and integral
gain pair (gamma_e, gamma_I) = (gamma, gamma nu) with the integrator measured as a speed.  The
coupling weights are f1 = psi'(U) and f2 = 1 - psi'(U), a convex sum: some actuator always acts, and
the loop gain is the same everywhere.  Tables and ramp are continuous, so neither command jumps
unless the measured speed or, without a filter, the wind estimate does.

Set-points of rotor speed and electrical power may be taken at run time (``SetpointInputs``).  With
a lower reference speed, omega* + r, and a lower torque in the place of T_rated, T_s, the demanded
effort is U = q* + s(v) r + (T_rated - T_s) n_g/J + u.

With the integrator scaled by nu(v), a slow loop (at low wind little torque is in reserve) is a fast
loop on another time scale. Therefore one quadratic function can show decay at all winds.

The effort-sharing loop in one cell of winds: its region, its coefficients' ranges, its corners.

The loop's matrix is affine in each coefficient when the others are held, so over a box of
coefficients it lies in the convex hull of its corners; the disturbance likewise.  The checker's
``turbine.effort_sharing.loop_claim`` writes the loop out, in the coordinates (e, zeta, x).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import exp
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, frozen
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.schedule import EffortSchedule
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.ramps import effort_ramp_slope
from takagi.models.turbine.data import Turbine

# Slower than tower, flap and wake (0.5 s and 3 to 8 s for 5 MW). An estimate from rotor speed takes
# their motion for wind. A schedule that followed it at once would close a feedback that oscillates.
DEFAULT_WIND_FILTER = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class EffortGains:
    """Gains over the nodes of an effort schedule.

    Attributes
    ----------
    proportional : (K,) gamma [1/s] at the nodes, linear between them.
    integral_rate : (K - 1,) nu [1/s], constant on each interval between nodes.
    """

    proportional: Floats
    integral_rate: Floats

    def __post_init__(self) -> None:
        for name in ("proportional", "integral_rate"):
            column = frozen(self, name)
            if column.ndim != 1 or not np.all(np.isfinite(column)) or np.any(column <= 0):
                raise ModelError(f"{name} must be a row of positive numbers, one per node/interval")
        if len(self.integral_rate) != len(self.proportional) - 1:
            raise ModelError(
                f"{len(self.proportional)} proportional gains need {len(self.proportional) - 1} "
                f"integral rates, one per interval; {len(self.integral_rate)} were given"
            )


class Operation(NamedTuple):
    """The rotor speed [rad/s] and the torque [N m] that set-points allow."""

    speed: float
    torque: float


@dataclass(frozen=True, slots=True, eq=False)
class SetpointInputs:
    """The set-points that a law takes at run time: from the lowest to the rated ones.

    Attributes
    ----------
    lowest_speed : of the rotor [rad/s].   lowest_torque : [N m, high-speed shaft].
    power_per_torque : electrical power over torque times rotor speed, efficiency times n_g [-].
    speed_effort : (K,) s, effort per change of the reference speed, at the nodes [1/s].
    """

    lowest_speed: float
    lowest_torque: float
    power_per_torque: float
    speed_effort: Floats

    def operation(self, speed: float, power: float, rated: Operation) -> Operation:
        """Return what a speed [rad/s] and a power set-point [W] allow.

        Torque falls first, to the lowest; where that is not enough, speed falls too.
        """
        lowest, factor = self.lowest_torque, self.power_per_torque
        slowed = min(speed, power / (factor * lowest))
        slowed = min(max(slowed, self.lowest_speed), rated.speed)
        return Operation(slowed, min(max(power / (factor * slowed), lowest), rated.torque))


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingLaw:
    """The effort-sharing law as a value; see the module's formulas.

    Attributes
    ----------
    schedule, gains : the emitted tables.
    rated_torque : T_rated [N m], high-speed shaft.
    effort_torque : J / n_g, torque per unit of effort [N m s^2/rad].
    pitch_min, pitch_max : [rad].
    wind_filter : tau_f [s]; 0 passes the estimate through.
    integral_limit : the integrator is held at |x| = this [rad/s]; a certified set lies inside.
    setpoints : which set-points the law takes at run time; None for none.
    operation : what the set-points allow now, see ``at_setpoints``; None for the rated ones.
    """

    schedule: EffortSchedule
    gains: EffortGains
    rated_torque: float
    effort_torque: float
    pitch_min: float
    pitch_max: float
    wind_filter: float = DEFAULT_WIND_FILTER
    integral_limit: float = 0.1
    setpoints: SetpointInputs | None = None
    operation: Operation | None = None
    name: str = "coherent"
    state_names: tuple[str, ...] = ("speed integral [rad/s]", "schedule wind [m/s]")

    def __post_init__(self) -> None:
        for name, low, high in (
            ("pitch", self.pitch_min, self.pitch_max),
            ("torque", 0.0, self.rated_torque),
            ("the integral", -self.integral_limit, self.integral_limit),
        ):
            if low > high:
                raise ModelError(
                    f"limits of {name} from {low:.6g} to {high:.6g} were given; the lower one must "
                    "not be above the upper one"
                )

    @classmethod
    def of(
        cls,
        turbine: Turbine,
        schedule: EffortSchedule,
        gains: EffortGains,
        *,
        wind_filter: float = DEFAULT_WIND_FILTER,
    ) -> EffortSharingLaw:
        """Return the law with the turbine's limits.

        Raises
        ------
        ModelError : sizes that differ.
        """
        if len(gains.proportional) != len(schedule.wind):
            raise ModelError(
                f"{len(gains.proportional)} gains for {len(schedule.wind)} wind nodes; one each"
            )
        return cls(
            schedule=schedule,
            gains=gains,
            rated_torque=turbine.rated_torque,
            effort_torque=turbine.inertia / turbine.gear_ratio,
            pitch_min=turbine.pitch_min,
            pitch_max=turbine.pitch_max,
            wind_filter=wind_filter,
        )

    def at_setpoints(self, *, speed: float, power: float) -> EffortSharingLaw:
        """Return the law with these set-points [rad/s, W], constant from now on.

        Raises
        ------
        ModelError : a law that takes no set-points.
        """
        if self.setpoints is None:
            raise ModelError(
                "set-points were given for a law that takes none at run time; design it with "
                "--lowest-speed-setpoint or --lowest-torque-setpoint"
            )
        rated = Operation(float(self.schedule.rotor_speed[-1]), self.rated_torque)
        return replace(self, operation=self.setpoints.operation(speed, power, rated))

    def initial_state(self, wind: float) -> Floats:
        """Return x = 0 and the schedule wind at the given wind [m/s]."""
        return np.array([0.0, self._inside(wind)])

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad]."""
        x, wind = self._unpacked(state, measurement)
        table = _columns(self)
        k, share = _place(table.wind, wind)
        reference, effort, most = self._references(table, k, share)
        signal = measurement.rotor_speed - reference - x
        effort += _between(table.proportional, k, share) * signal
        overlap = self.schedule.overlap
        torque = most - self.effort_torque * _ramp(-effort, overlap)
        pitch = self.pitch_min + _ramp(effort, overlap) / _between(table.effectiveness, k, share)
        return Command(min(max(torque, 0.0), most), min(max(pitch, self.pitch_min), self.pitch_max))

    def _references(self, table: _Columns, k: int, share: float) -> tuple[float, float, float]:
        """Return reference speed [rad/s], effort at rest [rad/s^2] and largest torque [N m]."""
        speed = _between(table.rotor_speed, k, share)
        effort = _between(table.trim_effort, k, share)
        if self.setpoints is None or self.operation is None:
            return speed, effort, self.rated_torque
        reduction = min(self.operation.speed - speed, 0.0)
        effort += _between(tuple(self.setpoints.speed_effort.tolist()), k, share) * reduction
        effort += (self.rated_torque - self.operation.torque) / self.effort_torque
        return speed + reduction, effort, self.operation.torque

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> Floats:
        """Return (x', v_f'); the integrator is held at its limit."""
        x, wind = self._unpacked(state, measurement)
        wind_rate = 0.0
        if self.wind_filter > 0:
            wind_rate = (self._inside(measurement.wind_estimate) - wind) / self.wind_filter
        return np.array([self._integral_rate(x, wind, measurement), wind_rate])

    def _integral_rate(self, x: float, wind: float, measurement: Measurement) -> float:
        table = _columns(self)
        k, share = _place(table.wind, wind)
        error = measurement.rotor_speed - self._references(table, k, share)[0]
        rate = -table.integral_rate[k] * error
        return 0.0 if abs(x) >= self.integral_limit and rate * x > 0 else rate

    def advance(self, state: ArrayLike, measurement: Measurement, time: float) -> Floats:
        """Return the state ``time`` [s] later, the measurement held.

        The filter is discretised exactly, v_f <- v_hat + (v_f - v_hat) exp(-time / tau_f), so that
        any ratio of sample time to tau_f is stable; the integral takes an Euler step and stops at
        its limit.
        """
        x, filtered = (float(value) for value in np.asarray(state))
        rate = self._integral_rate(x, self._unpacked(state, measurement)[1], measurement)
        limit = self.integral_limit
        if self.wind_filter > 0:
            estimate = self._inside(measurement.wind_estimate)
            filtered = estimate + (filtered - estimate) * exp(-time / self.wind_filter)
        return np.array([min(max(x + time * rate, -limit), limit), filtered])

    def sample(
        self, state: ArrayLike, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        """Return the command at a sample and the state at the next one, ``time`` [s] later."""
        return self.command(state, measurement), self.advance(state, measurement, time)

    def pitch_share(self, wind: float) -> float:
        """Return f1 = psi'(q*(v)), the share of pitch in the loop at the trim."""
        q = float(np.interp(wind, self.schedule.wind, self.schedule.trim_effort))
        return float(effort_ramp_slope(q, self.schedule.overlap))

    def _unpacked(self, state: ArrayLike, measurement: Measurement) -> tuple[float, float]:
        """Return x and the schedule wind."""
        x, wind = np.asarray(state, dtype=np.float64).tolist()
        return x, wind if self.wind_filter > 0 else self._inside(measurement.wind_estimate)

    def _inside(self, wind: float) -> float:
        nodes = _columns(self).wind
        return float(min(max(wind, nodes[0]), nodes[-1]))


class _Columns(NamedTuple):
    """The law's tables as Python floats, because a simulation reads them at every sample."""

    wind: tuple[float, ...]
    rotor_speed: tuple[float, ...]
    trim_effort: tuple[float, ...]
    effectiveness: tuple[float, ...]
    proportional: tuple[float, ...]
    integral_rate: tuple[float, ...]


@lru_cache(maxsize=32)
def _columns(law: EffortSharingLaw) -> _Columns:
    homes = (*(law.schedule,) * 4, *(law.gains,) * 2)
    pairs = zip(homes, _Columns._fields, strict=True)
    return _Columns(*(tuple(getattr(home, name).tolist()) for home, name in pairs))


def _place(nodes: tuple[float, ...], wind: float) -> tuple[int, float]:
    k = min(max(bisect_right(nodes, wind) - 1, 0), len(nodes) - 2)
    return k, (wind - nodes[k]) / (nodes[k + 1] - nodes[k])


def _between(column: tuple[float, ...], k: int, share: float) -> float:
    return column[k] + share * (column[k + 1] - column[k])


def _ramp(effort: float, overlap: float) -> float:
    """Return psi for one float; the array form costs ten times as much in a simulation's loop."""
    if effort <= -overlap:
        return 0.0
    above = effort + overlap
    return effort if effort >= overlap else above * above / (4 * overlap)


NOMINAL = Interval(Fraction(1), Fraction(1))


@dataclass(frozen=True, slots=True)
class LoopBox:
    """The region on which the family is valid, around the trim at the schedule wind.

    Attributes
    ----------
    speed_error : bound on |e| [rad/s].
    effort_lag : bound on |zeta| [rad/s^2].
    speed_signal : bound on |e - x| [rad/s]; the demanded effort is gamma times this.
    wind_share : bound on |v - v_s| over the cell's lower wind [-], up to which d is enclosed.
    """

    speed_error: Fraction
    effort_lag: Fraction
    speed_signal: Fraction
    wind_share: Fraction

    @property
    def directions(self) -> Floats:
        """(3, 3) rows h_i: (e, zeta, x) is in the box where |h_i' (e, zeta, x)| <= 1."""
        e, z, y = (float(b) for b in (self.speed_error, self.effort_lag, self.speed_signal))
        return np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]])


@dataclass(frozen=True, slots=True)
class LoopUncertainty:
    """The uncertainty that the family covers in addition to the nominal model.

    Attributes
    ----------
    inertia : the true inertia over the nominal one, e.g. [0.9, 1.1].
    frozen_wake : whether pitch effectiveness may reach the frozen-wake value.
    power_coefficient : the true c_P over the table's, e.g. [0.98, 1.02]; one factor for all pitch
        angles and tip-speed ratios.
    """

    inertia: Interval
    frozen_wake: bool
    power_coefficient: Interval = NOMINAL


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCell:
    """Enclosures of the loop's coefficients for schedule winds in one cell, moving at some rate.

    Attributes
    ----------
    wind : schedule winds [m/s];  wind_rate : |v_s'| [m/s^2] that is enclosed.
    stiffness : a [1/s];  loop_gain : Gamma [1/s];  lag_gain : S [-];  share_gain : Phi [1/s].
    lag_rate : T [1/s];  integral_rate : nu [1/s], a point.
    effectiveness_limit : b of the frozen wake [rad/s^2 per rad], by the law's table.
    residual : |r| [rad/s^2];  wind_gain : |d| [rad/s per m];  inertia_gain : largest kappa [-].
    effectiveness_slope : |b'/b| [1/m].
    reference_slope : |omega*'| [rad/s per m/s].
    lag_disturbance : |w_zeta| [rad/s^3], of the moving schedule wind.
    """

    wind: Interval
    wind_rate: Fraction
    stiffness: Interval
    loop_gain: Interval
    lag_gain: Interval
    share_gain: Interval
    lag_rate: Interval
    integral_rate: Interval
    effectiveness_limit: Interval
    residual: Fraction
    wind_gain: Fraction
    inertia_gain: Fraction
    effectiveness_slope: Fraction
    reference_slope: Fraction
    lag_disturbance: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class LoopVertices:
    """Corners of one cell.

    Attributes
    ----------
    A : (N, 3, 3) in (e [rad/s], zeta [rad/s^2], x [rad/s]), with a schedule wind that moves at up
        to the cell's rate.
    at_rest : (M, 3, 3) with a constant schedule wind.
    fixed : (N, 3) disturbance of the tables' residual and of the cell's wind rate;
    per_wind_error : (N, 3) per m/s of |v - v_s|.  Each of them at a corner of the signs.
    """

    A: Floats
    at_rest: Floats
    fixed: Floats
    per_wind_error: Floats


def loop_vertices(cell: LoopCell) -> LoopVertices:
    """Return the corners of the cell's coefficients, with both relative signs of (w_e, w_zeta).

    Opposite signs of both give the mirrored inequality, so one sign of w_e suffices. If w_zeta is
    zero there is only one sign.  T - (b'/b) v_s' is one coefficient, in a wider range than T.
    """
    rate = float(cell.wind_rate)
    steady = float(cell.inertia_gain * cell.residual) + float(cell.reference_slope) * rate
    error = float(cell.inertia_gain * cell.wind_gain)
    lag = float(cell.lag_disturbance)
    turning = cell.effectiveness_slope * cell.wind_rate
    moving = Interval(cell.lag_rate.lower - turning, cell.lag_rate.upper + turning)
    A, fixed, by_error = [], [], []
    for matrix, phi in _matrices(cell, moving):
        for sign in (1.0, -1.0) if lag else (1.0,):
            A.append(matrix)
            fixed.append([steady, phi * steady + sign * lag, 0.0])
            by_error.append([error, phi * error, 0.0])
    at_rest = [matrix for matrix, _ in _matrices(cell, cell.lag_rate)]
    return LoopVertices(np.array(A), np.array(at_rest), np.array(fixed), np.array(by_error))


def _matrices(cell: LoopCell, lag_rate: Interval) -> Iterator[tuple[list[list[float]], float]]:
    """Yield the matrix at each corner, and its Phi."""
    nu = float(cell.integral_rate.lower)
    ranges = (cell.stiffness, cell.loop_gain, cell.lag_gain, cell.share_gain, lag_rate)
    for a, gamma, s, phi, rate in product(*map(_ends, ranges)):
        yield (
            [
                [a - gamma, s, gamma],
                [phi * (a - gamma + nu), phi * s - rate, phi * gamma],
                [-nu, 0.0, 0.0],
            ],
            phi,
        )


def _ends(interval: Interval) -> tuple[float, ...]:
    low, high = float(interval.lower), float(interval.upper)
    return (low,) if low == high else (low, high)
