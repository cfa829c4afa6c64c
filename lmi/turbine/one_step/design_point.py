"""The values that given gains achieve.

The values that given gains and Lyapunov functions achieve, and the objective of these values.

Standard deviations of pitch rate and tower speed in turbulence: a linear estimate, no bound.

The one-step design compares gains by these numbers; no certificate uses them.  At the middle of
each wind cell the law and the turbine are linearised about the trim by central differences.  The
model includes the tower's fore-aft mode,

    m y'' = F(omega, beta, v - y') - F_0 - c y' - k y ,

and a wind v' = -(v - v_0) / T + sqrt(2 / T) n of standard deviation 1 m/s, where T = L / v_0 and n
is white noise of unit intensity.  The law's wind estimate is the wind itself.  The covariance X of
the state solves A X + X A' + B B' = 0.  The objective uses the mean over the wind range.

Source: Brogan (1991), Modern Control Theory, section 11.5 (covariance of a linear system);
L = 8.1 * 42 m is the Kaimal length of the longitudinal component in IEC 61400-1 ed. 3, Annex B
(recalled); the first-order wind has the same spectrum at low frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.turbine.one_step.joint_step import Weights
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    LoopOfGains,
    reached_by_function,
)
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Measurement
from takagi.models.turbine.data import Turbine, rotor_thrust, rotor_torque

TURBULENCE_LENGTH = 8.1 * 42.0  # m
# Steps of the central differences for rotor speed, pitch, integral, schedule wind, tower position,
# tower speed and wind, each small beside the range over which the loop's slopes change.
STEPS = np.array([1e-4, 1e-5, 1e-4, 1e-3, 1e-3, 1e-3, 1e-3])


@dataclass(frozen=True, slots=True, eq=False)
class PitchAndTowerMotion:
    """Standard deviations in each wind cell, for a wind of standard deviation 1 m/s.

    All three are inf in a cell where the linear loop is not stable.

    Attributes
    ----------
    speed : (K - 1,) of omega - omega* [rad/s];  pitch_rate : (K - 1,) [rad/s];  tower_speed :
        (K - 1,) of y' [m/s].
    """

    speed: Floats
    pitch_rate: Floats
    tower_speed: Floats


def motion(
    turbine: Turbine, law: EffortSharingLaw, cells: range | None = None
) -> PitchAndTowerMotion:
    """Return the standard deviations in the given wind cells; in all cells for ``None``."""
    nodes = law.schedule.wind
    chosen = range(len(nodes) - 1) if cells is None else cells
    rows = [_deviations(turbine, law, (nodes[k] + nodes[k + 1]) / 2) for k in chosen]
    speed, pitch, tower = np.array(rows, dtype=np.float64).reshape(-1, 3).T
    return PitchAndTowerMotion(speed, pitch, tower)


def _deviations(turbine: Turbine, law: EffortSharingLaw, wind: float) -> tuple[float, float, float]:
    at = np.array([_between(law, law.schedule.rotor_speed, wind), 0, 0, wind, 0, 0, wind])
    at[1] = law.schedule.pitch(wind, turbine)
    thrust = float(rotor_thrust(turbine, at[0], at[1], wind))
    rates = _loop(turbine, law, thrust)
    jacobian = np.empty((7, 7))
    for column, step in enumerate(STEPS):
        beside = np.zeros(7)
        beside[column] = step
        jacobian[:, column] = (rates(at + beside) - rates(at - beside)) / (2 * step)
    # 1 / T of the first-order wind: turbulence passes the rotor with the mean wind speed.
    pace = wind / TURBULENCE_LENGTH
    # The wind filters white noise; the loop does not act on it.
    jacobian[6] = 0.0
    jacobian[6, 6] = -pace
    # The Lyapunov equation of an unstable loop has a solution too, but it is no covariance.
    if np.linalg.eigvals(jacobian).real.max() >= 0:
        return np.inf, np.inf, np.inf
    noise = np.zeros((7, 7))
    noise[6, 6] = 2 * pace
    X = solve_continuous_lyapunov(jacobian, -noise)
    node = min(int(np.searchsorted(law.schedule.wind, wind)) - 1, len(law.schedule.wind) - 2)
    slope = np.diff(law.schedule.rotor_speed)[node] / np.diff(law.schedule.wind)[node]
    # omega* moves with the schedule wind: the error is omega - (d omega* / d v_s) v_s.
    error = np.eye(7)[0] - slope * np.eye(7)[3]
    return tuple(float(np.sqrt(max(h @ X @ h, 0.0))) for h in (error, jacobian[1], np.eye(7)[5]))  # type: ignore[return-value]


def _loop(turbine: Turbine, law: EffortSharingLaw, thrust: float) -> Callable[[Floats], Floats]:
    """Return the function z -> dz/dt of z = (omega, beta, x, v_s, y, y', v).

    The rate of the wind is 0 here; the caller adds the first-order wind.
    """

    def rates(z: Floats) -> Floats:
        omega, beta, x, scheduled, y, moving, wind = z
        # The rotor meets the wind relative to the tower top, which is the tower's aerodynamic
        # damping.
        relative_wind = wind - moving
        measured = Measurement(omega, beta, wind)
        state = np.array([x, scheduled])
        command = law.command(state, measured)
        torque = float(rotor_torque(turbine, omega, beta, relative_wind))
        push = float(rotor_thrust(turbine, omega, beta, relative_wind)) - thrust
        integral, follow = law.state_rate(state, measured)
        return np.array(
            [
                (torque - turbine.gear_ratio * command.torque) / turbine.inertia,
                (command.pitch - beta) / turbine.pitch_time_constant,
                integral,
                follow,
                moving,
                (push - turbine.tower_damping * moving - turbine.tower_stiffness * y)
                / turbine.tower_mass,
                0.0,
            ]
        )

    return rates


def _between(law: EffortSharingLaw, column: Floats, wind: float) -> float:
    return float(np.interp(wind, law.schedule.wind, column))


@dataclass(frozen=True, slots=True)
class ReachedValues:
    """Values that given gains achieve; the same analysis computes them for all gains.

    Attributes
    ----------
    wind_error : geometric mean over wind of the largest |v - v_s| for which {x' P x <= 1} is
        invariant [m/s], while the schedule wind moves at the requested rates.
    overspeed : largest |omega - omega*| on that set [rad/s].
    decay_rate : common decay rate at constant wind that R proves in floats [1/s]; nan during the
        search when the objective gives it no weight.
    pitch_rate, tower_speed : means over wind of the standard deviations per m/s of turbulence
        [rad/s, m/s]; nan when the objective gives them no weight.
    """

    wind_error: float
    overspeed: float
    decay_rate: float
    pitch_rate: float
    tower_speed: float


@dataclass(frozen=True, slots=True, eq=False)
class DesignPoint:
    """Gains, their Lyapunov functions, the values they achieve, and the objective.

    A smaller objective ``value`` is better.  ``floor`` is the multiple of the requested wind error
    that every cell must tolerate.
    """

    theta: Floats
    functions: LoopFunctions
    reached: ReachedValues
    value: float
    floor: float = 0.0


def mean_error(loop: LoopOfGains, functions: LoopFunctions) -> float:
    """Return the geometric mean over wind of the wind error that P tolerates [m/s]."""
    return float(np.exp(shares_of(loop) @ np.log(functions.scales * loop.error)))


def function_value(loop: LoopOfGains, functions: LoopFunctions, aim: Objective) -> float:
    """Return the objective without its terms for pitch and tower motion in turbulence."""
    peak = float(reached_by_function(functions.P, loop.box.directions[:1])[0]) ** 0.5
    value = -aim.wind_class * float(shares_of(loop) @ np.log(functions.scales))
    if aim.decay > 0:
        value -= aim.decay * np.log(functions.decay_rate)
    return value + aim.overspeed * float(np.log(peak))


def design_point(
    loop: LoopOfGains, theta: Floats, functions: LoopFunctions, aim: Objective
) -> DesignPoint | None:
    """Return the point with its values; None if the linear loop about a trim is not stable."""
    peak = float(reached_by_function(functions.P, loop.box.directions[:1])[0]) ** 0.5
    share = shares_of(loop)
    pitch = tower = np.nan
    value = function_value(loop, functions, aim)
    if aim.watches_motion:
        motion_values = motion(loop.turbine, loop.at(theta))
        pitch, tower = (
            float(share @ motion_values.pitch_rate),
            float(share @ motion_values.tower_speed),
        )
        value += aim.pitch * np.log(pitch) + aim.tower * np.log(tower)
    reached = ReachedValues(
        mean_error(loop, functions),
        float(loop.box.speed_error) * peak,
        functions.decay_rate if functions.decay_rate > 0 else np.nan,
        pitch,
        tower,
    )
    # An unstable linear loop has infinite standard deviations, so its objective is not finite.
    return DesignPoint(theta, functions, reached, float(value)) if np.isfinite(value) else None


def weights_at(loop: LoopOfGains, spot: DesignPoint, aim: Objective) -> Weights:
    """Return the weights of one convex step: the gradient of the objective at the point."""
    gains = np.zeros(len(spot.theta))
    if aim.watches_motion:
        gains = _motion_slopes(loop, spot, aim)
    shares = shares_of(loop)
    return Weights(aim.wind_class * shares, aim.overspeed, aim.decay, gains, shares)


def _motion_slopes(loop: LoopOfGains, spot: DesignPoint, aim: Objective) -> Floats:
    """Return d (weighted logarithms of pitch rate and tower speed) / d (logarithms of the gains).

    Two evaluations serve all gains: the motion in a cell depends on that cell's gains alone, so
    all gamma are raised together, then all nu.  A cell's change by gamma is shared equally by the
    nodes at its two ends.
    """
    # One per cent: large against the rounding of the estimates, small against their curvature.
    nodes, step = loop.cells + 1, 1e-2
    share = shares_of(loop)
    slopes = np.zeros(len(spot.theta))
    faster = [spot.theta.copy(), spot.theta.copy()]
    faster[0][:nodes] *= np.exp(step)
    faster[1][nodes:] *= np.exp(step)
    here = motion(loop.turbine, loop.at(spot.theta))
    for gain_number, theta in enumerate(faster):
        there = motion(loop.turbine, loop.at(theta))
        change = (
            aim.pitch * (there.pitch_rate - here.pitch_rate) / (share @ here.pitch_rate)
            + aim.tower * (there.tower_speed - here.tower_speed) / (share @ here.tower_speed)
        ) * (share / step)
        if gain_number == 0:
            slopes[: nodes - 1] += change / 2
            slopes[1:nodes] += change / 2
        else:
            slopes[nodes:] += change
    return slopes


def shares_of(loop: LoopOfGains) -> Floats:
    """Return (K - 1,): the width of each wind cell divided by the whole wind range."""
    widths = np.diff(loop.law.schedule.wind)
    return np.asarray(widths / widths.sum(), dtype=np.float64)


def widest_multiples(loop: LoopOfGains) -> Floats:
    """Return (K - 1,): the largest multiple of the wind error for which the enclosures hold.

    A cell's ranges are enclosed for wind errors up to a share of its lowest wind; beyond, the
    corners say nothing.
    """
    wind = loop.law.schedule.wind[:-1]
    return np.asarray(float(loop.box.wind_share) * wind / loop.error, dtype=np.float64)
