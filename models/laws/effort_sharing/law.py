r"""The coherent law: one effort, shared between torque and pitch by a ramp.

With e = omega - omega*(v_f) and the states x [rad/s] and v_f [m/s],

    u  = gamma(v_f) (e - x)                    PI action, read as effort [rad/s^2]
    U  = q*(v_f) + u                           demanded effort
    T  = T_rated - (J / n_g) (psi(-U) + a_f)   torque delivers up to rated ...
    beta_ref = beta_min + psi(U) / b(v_f) + beta_f      ... and pitch whatever lies beyond
    x'   = -nu(v_f) e
    v_f' = (v_hat - v_f) / tau_f               low-pass on the wind estimate

with the feed-forward of v_f', which the law knows (``feedforward``),

    a_f    = f v_f' held within +-g            effort that the moving reference speed takes
    beta_f = tau_lead v_f' d/dv_f [psi(U) / b] at fixed e - x
           = tau_lead v_f' (psi'(U) (q*' + gamma' (e - x)) - psi(U) b' / b) / b,

torque held within [0, T_rated] and pitch within its limits.  It is the proportional and integral
gain pair (gamma_e, gamma_I) = (gamma, gamma nu) with the integrator measured as a speed.  The
coupling weights are f1 = psi'(U) and f2 = 1 - psi'(U), a convex sum: some actuator always acts, and
the loop gain is the same everywhere.  The feed-forward enters neither U nor a state, so a jump of
the wind estimate moves neither.

Scaling the integrator by nu(v) makes a slow loop (little torque in reserve at low wind) the
time-scaled image of a fast one, which is what lets one quadratic function serve all winds.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.feedforward import (
    Feedforward,
    known_rate_feedforward,
    no_feedforward,
)
from takagi.models.laws.effort_sharing.schedule import EffortSchedule
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.ramps.effort_ramp import effort_ramp, effort_ramp_slope
from takagi.models.turbine.data import Turbine

# Slow beside tower, flap and wake (0.5 s and 3 to 8 s for 5 MW): an estimate from rotor speed sees
# their motion as wind, and a schedule that follows at once makes it a feedback that swings.
DEFAULT_WIND_FILTER = 5.0


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
            column = np.array(getattr(self, name), dtype=np.float64)
            if column.ndim != 1 or not np.all(np.isfinite(column)) or np.any(column <= 0):
                raise ModelError(f"{name} must be a row of positive numbers, one per node/interval")
            column.flags.writeable = False
            object.__setattr__(self, name, column)
        if len(self.integral_rate) != len(self.proportional) - 1:
            raise ModelError(
                f"{len(self.proportional)} proportional gains need {len(self.proportional) - 1} "
                f"integral rates, one per interval; {len(self.integral_rate)} were given"
            )


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingLaw:
    """The effort-sharing law as a value; see the module's formulas.

    Attributes
    ----------
    schedule, gains, feedforward : the emitted tables.
    rated_torque : T_rated [N m], high-speed shaft.
    effort_torque : J / n_g, torque per unit of effort [N m s^2/rad].
    pitch_min, pitch_max : [rad].
    wind_filter : tau_f [s]; 0 passes the estimate through, whose rate is then unknown: nothing
        may be fed forward.
    integral_limit : the integrator is held at |x| = this [rad/s]; a certified set lies inside.
    """

    schedule: EffortSchedule
    gains: EffortGains
    feedforward: Feedforward
    rated_torque: float
    effort_torque: float
    pitch_min: float
    pitch_max: float
    wind_filter: float = DEFAULT_WIND_FILTER
    integral_limit: float = 0.1
    name: str = "coherent"
    state_names: tuple[str, ...] = ("speed integral [rad/s]", "schedule wind [m/s]")

    def __post_init__(self) -> None:
        intervals = len(self.schedule.wind) - 1
        if len(self.feedforward.inertia) != intervals:
            raise ModelError(
                f"{len(self.feedforward.inertia)} feed-forwards for {intervals} intervals between "
                "wind nodes; one each"
            )
        if self.wind_filter <= 0 and self.feedforward.acts:
            raise ModelError(
                f"wind filter {self.wind_filter:.4g} s: without a filter the schedule wind's rate "
                "is unknown; give a positive time constant, or no feed-forward"
            )

    @classmethod
    def of(
        cls,
        turbine: Turbine,
        schedule: EffortSchedule,
        gains: EffortGains,
        *,
        feedforward: Feedforward | None = None,
        wind_filter: float = DEFAULT_WIND_FILTER,
        integral_limit: float = 0.1,
    ) -> EffortSharingLaw:
        """Return the law with the turbine's limits.

        Parameters
        ----------
        feedforward : None takes ``known_rate_feedforward``, or nothing without a wind filter.

        Raises
        ------
        ModelError : sizes that differ.
        """
        if len(gains.proportional) != len(schedule.wind):
            raise ModelError(
                f"{len(gains.proportional)} gains for {len(schedule.wind)} wind nodes; one each"
            )
        if feedforward is None and wind_filter <= 0:
            feedforward = no_feedforward(schedule)
        return cls(
            schedule=schedule,
            gains=gains,
            feedforward=feedforward or known_rate_feedforward(turbine, schedule),
            rated_torque=turbine.rated_torque,
            effort_torque=turbine.inertia / turbine.gear_ratio,
            pitch_min=turbine.pitch_min,
            pitch_max=turbine.pitch_max,
            wind_filter=wind_filter,
            integral_limit=integral_limit,
        )

    def initial_state(self, wind: float) -> Floats:
        """Return x = 0 and the schedule wind at the given wind [m/s]."""
        return np.array([0.0, self._inside(wind)])

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad]."""
        wind = self._schedule_wind(state, measurement)
        return self._command(state, measurement, self._wind_rate(wind, measurement))

    def _command(self, state: ArrayLike, measurement: Measurement, rate: float) -> Command:
        """Return the command with ``rate`` [m/s^2] as v_f'."""
        x, wind = float(np.asarray(state)[0]), self._schedule_wind(state, measurement)
        k, share = self._place(wind)
        table, ahead = self.schedule, self.feedforward
        signal = measurement.rotor_speed - _between(table.rotor_speed, k, share) - x
        effort = _between(table.trim_effort, k, share)
        effort += _between(self.gains.proportional, k, share) * signal
        limit = float(ahead.effort_limit[k])
        taken = min(max(float(ahead.inertia[k]) * rate, -limit), limit)
        reserve = _ramp(-effort, table.overlap) + taken
        torque = self.rated_torque - self.effort_torque * reserve
        shed = _ramp(effort, table.overlap) + ahead.pitch_lead * rate * self._shed_slope(
            k, share, signal, effort
        )
        pitch = self.pitch_min + shed / _between(table.effectiveness, k, share)
        return Command(
            min(max(torque, 0.0), self.rated_torque),
            min(max(pitch, self.pitch_min), self.pitch_max),
        )

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> Floats:
        """Return (x', v_f'); the integrator is held at its limit."""
        x = float(np.asarray(state)[0])
        wind = self._schedule_wind(state, measurement)
        k, share = self._place(wind)
        error = measurement.rotor_speed - _between(self.schedule.rotor_speed, k, share)
        rate = -float(self.gains.integral_rate[k]) * error
        if abs(x) >= self.integral_limit and rate * x > 0:
            rate = 0.0
        return np.array([rate, self._wind_rate(wind, measurement)])

    def advance(self, state: ArrayLike, measurement: Measurement, time: float) -> Floats:
        """Return the state ``time`` [s] later, the measurement held.

        The filter is discretised exactly, v_f <- v_hat + (v_f - v_hat) exp(-time / tau_f), so that
        any ratio of sample time to tau_f is stable; the integral takes an Euler step and stops at
        its limit.
        """
        x, wind = (float(value) for value in np.asarray(state))
        rate = float(self.state_rate(state, measurement)[0])
        limit = self.integral_limit
        if self.wind_filter > 0:
            seen = self._inside(measurement.wind_estimate)
            wind = seen + (wind - seen) * exp(-time / self.wind_filter)
        return np.array([min(max(x + time * rate, -limit), limit), wind])

    def sample(
        self, state: ArrayLike, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        """Return the command at a sample and the state at the next one, ``time`` [s] later.

        What is fed forward is the mean of v_f' until then, (v_f after - v_f) / time: on a ramp of
        the estimate that is the ramp's own rate, where v_f' at the sample would be more by
        (time / tau_f) / (1 - exp(-time / tau_f)), 21 % for 20 ms and tau_f = 50 ms.
        """
        later = self.advance(state, measurement, time)
        if self.wind_filter <= 0:
            return self.command(state, measurement), later
        rate = (float(later[1]) - float(np.asarray(state)[1])) / time
        return self._command(state, measurement, rate), later

    def pitch_share(self, wind: float) -> float:
        """Return f1 = psi'(q*(v)), the share of pitch in the loop at the trim."""
        q = float(np.interp(wind, self.schedule.wind, self.schedule.trim_effort))
        return float(effort_ramp_slope(q, self.schedule.overlap))

    def gain_pair(self, wind: float) -> tuple[float, float]:
        """Return (gamma_e, gamma_I) = (gamma, gamma nu) in 1/s and 1/s^2."""
        k, share = self._place(self._inside(wind))
        gamma = _between(self.gains.proportional, k, share)
        return gamma, gamma * float(self.gains.integral_rate[k])

    def _schedule_wind(self, state: ArrayLike, measurement: Measurement) -> float:
        if self.wind_filter <= 0:
            return self._inside(measurement.wind_estimate)
        return float(np.asarray(state)[1])

    def _wind_rate(self, wind: float, measurement: Measurement) -> float:
        """Return v_f' [m/s^2]; 0 without a filter."""
        if self.wind_filter <= 0:
            return 0.0
        return (self._inside(measurement.wind_estimate) - wind) / self.wind_filter

    def _shed_slope(self, k: int, share: float, signal: float, effort: float) -> float:
        """Return b d/dv_f [psi(U) / b] at fixed e - x [rad/s^2 per m/s]."""
        table, gains = self.schedule, self.gains.proportional
        width = float(table.wind[k + 1] - table.wind[k])
        moved = float(table.trim_effort[k + 1] - table.trim_effort[k])
        moved += float(gains[k + 1] - gains[k]) * signal
        bent = float(table.effectiveness[k + 1] - table.effectiveness[k])
        bent /= _between(table.effectiveness, k, share)
        slope = _ramp_slope(effort, table.overlap)
        return (slope * moved - _ramp(effort, table.overlap) * bent) / width

    def _inside(self, wind: float) -> float:
        nodes = self.schedule.wind
        return float(min(max(wind, nodes[0]), nodes[-1]))

    def _place(self, wind: float) -> tuple[int, float]:
        nodes = self.schedule.wind
        k = min(max(bisect_right(nodes, wind) - 1, 0), len(nodes) - 2)
        return k, float((wind - nodes[k]) / (nodes[k + 1] - nodes[k]))


def _between(column: Floats, k: int, share: float) -> float:
    return float(column[k]) + share * float(column[k + 1] - column[k])


def _ramp(effort: float, overlap: float) -> float:
    """Return psi for one float; the array form costs ten times as much in a simulation's loop."""
    if effort <= -overlap:
        return 0.0
    return effort if effort >= overlap else float(effort_ramp(effort, overlap))


def _ramp_slope(effort: float, overlap: float) -> float:
    """Return psi' for one float."""
    return min(max((effort + overlap) / (2 * overlap), 0.0), 1.0)


# Names that earlier versions had.
CoherentLaw = EffortSharingLaw
