"""The values that given gains and Lyapunov functions achieve, and the objective of these values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.turbine.one_step.joint_step import Weights
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    LoopOfGains,
    reached_by_function,
)
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
    """

    wind_error: float
    overspeed: float
    decay_rate: float


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
    """Return the objective, of which a smaller value is better."""
    peak = float(reached_by_function(functions.P, loop.box.directions[:1])[0]) ** 0.5
    value = -aim.wind_class * float(shares_of(loop) @ np.log(functions.scales))
    if aim.decay > 0:
        value -= aim.decay * np.log(functions.decay_rate)
    return value + aim.overspeed * float(np.log(peak))


def design_point(
    loop: LoopOfGains, theta: Floats, functions: LoopFunctions, aim: Objective
) -> DesignPoint:
    """Return the point with its values."""
    peak = float(reached_by_function(functions.P, loop.box.directions[:1])[0]) ** 0.5
    reached = ReachedValues(
        mean_error(loop, functions),
        float(loop.box.speed_error) * peak,
        functions.decay_rate if functions.decay_rate > 0 else np.nan,
    )
    return DesignPoint(theta, functions, reached, function_value(loop, functions, aim))


def weights_at(loop: LoopOfGains, aim: Objective) -> Weights:
    """Return the weights of one convex step."""
    shares = shares_of(loop)
    return Weights(aim.wind_class * shares, aim.overspeed, aim.decay, shares)


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
