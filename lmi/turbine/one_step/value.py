"""The values that given gains and Lyapunov functions achieve, and the objective of these values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.turbine.one_step.joint_step import Weights
from takagi.lmi.turbine.one_step.loop_functions import LoopFunctions, reached_by_function
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.lmi.turbine.one_step.motion import motion
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.models.arrays import Floats


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
        moved = motion(loop.turbine, loop.at(theta))
        pitch, tower = float(share @ moved.pitch_rate), float(share @ moved.tower_speed)
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
    for part, theta in enumerate(faster):
        there = motion(loop.turbine, loop.at(theta))
        change = (
            aim.pitch * (there.pitch_rate - here.pitch_rate) / (share @ here.pitch_rate)
            + aim.tower * (there.tower_speed - here.tower_speed) / (share @ here.tower_speed)
        ) * (share / step)
        if part == 0:
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
