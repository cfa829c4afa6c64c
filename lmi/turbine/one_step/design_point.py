"""What given gains and Lyapunov functions achieve, and its weighted sum: the objective."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np

from takagi.lmi.turbine.one_step.joint_step import Weights
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    LoopOfGains,
    reached_by_function,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean


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


def weights_at(
    loop: LoopOfGains, aim: Objective, *, log_mean: float | None, floor: float
) -> Weights:
    """Return the weights of one convex step, and its limits: see ``Weights``."""
    shares, floors = shares_of(loop), np.full(loop.cells, floor)
    return Weights(aim.wind_class * shares, aim.overspeed, aim.decay, shares, log_mean, floors)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Objective:
    """Weights of an objective: the sum of weight times logarithm of each quantity is minimised.

    A quantity that shall grow enters with a minus sign.  Logarithms make the weights independent
    of units: equal weights trade one per cent of one quantity for one per cent of another.

    Attributes
    ----------
    wind_class : weight of the largest multiple of the wind class for which {x' P x <= 1} is
        invariant and inside the box.
    overspeed : weight of the peak of the speed error under the wind class that was requested.
    decay : weight of the common decay rate at constant wind.
    kept : every step keeps at least this share of the wind error that the starting gains tolerate,
        on the mean over wind and in the weakest cell.
    """

    wind_class: float = 1.0
    overspeed: float = 0.0
    decay: float = 0.0
    kept: float = 1.0

    def __post_init__(self) -> None:
        weights = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in weights.items():
            if not 0 <= value < 1e3:
                raise ModelError(f"{name} = {value!r} was given; a number from 0 to 1000 is needed")
        if not 0 < self.kept <= 1:
            raise ModelError(f"kept = {self.kept!r} was given; a share above 0, up to 1, is needed")
        if not sum(value for name, value in weights.items() if name != "kept") > 0:
            raise ModelError("all weights are 0; give at least one objective a weight above 0")


# Named sets of weights.  In our runs ``balanced`` reached the same wind class as ``wind-class`` and
# took half as much time again, because the decay rate adds inequalities of its own.
OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        "balanced": Objective(decay=0.1),
        "wind-class": Objective(),
        "decay": Objective(wind_class=0.1, decay=1.0),
    }
)


def objective_named(name: str) -> Objective:
    """Return the weights that belong to a name.

    Raises
    ------
    ModelError : the name is unknown; the message lists the known names.
    """
    if name not in OBJECTIVES:
        raise ModelError(
            f"objective {name!r} was given{did_you_mean(name, OBJECTIVES)}; choose one of "
            f"{', '.join(OBJECTIVES)}"
        )
    return OBJECTIVES[name]
