"""From gains to better ones: each step enclosed anew, and kept where the objective fell."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.analysis.decay_rate import max_decay_rate
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, invariant_ellipsoid
from takagi.lmi.turbine.one_step_family import Corners, LoopFamily, Moving
from takagi.lmi.turbine.one_step_motion import motion
from takagi.lmi.turbine.one_step_objective import Objective
from takagi.lmi.turbine.one_step_search import (
    Functions,
    Room,
    Weights,
    borne,
    joint_step,
    reach_of,
)
from takagi.models.errors import ModelError

__all__ = ["Climb", "Reached", "Spot", "begun", "resting"]

Floats = NDArray[np.float64]

# Trust region: of each logarithm, at the start, at most, and where the search ends.
FIRST_REACH, LARGEST_REACH, LEAST_REACH = 0.1, 0.2, 0.01
WIDER, NARROWER = 1.5, 0.3
# Relative gain below which functions at given gains, and the climb, are left.
SETTLED, ENOUGH = 3e-3, 1e-3
# How far, relative, the mean wind error may fall below what is kept: solvers need some room.
ROOM = 1e-3
# Most improvements of functions with gains fixed: at the start, and after a step.
AT_START, AFTER_STEP = 8, 2


@dataclass(frozen=True, slots=True)
class Reached:
    """What gains reach, all by the same analysis.

    Attributes
    ----------
    wind_error : geometric mean over wind of the |v - v_s| that {x' P x <= 1} bears [m/s], with
        schedule winds that move at the rates asked for.
    overspeed : largest |omega - omega*| on that set [rad/s].
    decay_rate : common decay rate at constant wind that R shows [1/s]; nan on the way where the
        objective does not look at it.
    pitch_rate, tower_speed : means over wind of the standard deviations per m/s of turbulence
        [rad/s, m/s]; nan where the objective does not look at them.
    """

    wind_error: float
    overspeed: float
    decay_rate: float
    pitch_rate: float
    tower_speed: float


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """Gains, their functions, what they reach, and the objective (smaller is better)."""

    theta: Floats
    functions: Functions
    reached: Reached
    value: float


def begun(family: LoopFamily, theta: Floats, aim: Objective) -> Spot:
    """Return the spot at given gains, its functions from nothing.

    Raises
    ------
    ModelError : no function was found; says what to change.
    """
    windy, still = family.corners(theta)
    directions = _directions(family)
    nu = theta[family.cells + 1 :]
    d = windy.fixed + windy.error
    first = invariant_ellipsoid(windy.A, d, windy.cell, directions, speed=nu[windy.cell], rounds=3)
    rest = max_decay_rate(still.A)
    functions = None
    if first.P is not None and rest.P is not None:
        none = np.zeros(family.cells)
        given = Functions(np.asarray(first.P), none, none, np.asarray(rest.P), 0.0)
        functions = borne(windy, still, given, _limits(family))
    if functions is None:
        raise ModelError(
            "one-step design: the gains it starts from have no common quadratic function under "
            f"this wind class ({first.diagnosis or rest.diagnosis or 'a cell bears no wind error'})"
            "; lower the wind class, the uncertainty or the box, or change the bandwidth"
        )
    # The wind class first, whatever else is aimed at: it is what later steps must keep.
    opening = replace(aim, wind_class=max(aim.wind_class, 1.0), decay=0.0)
    functions = _settled(family, windy, still, functions, opening, AT_START)
    spot = _spot(family, theta, functions, aim)
    if spot is None:
        raise ModelError("one-step design: the linear loop at the start is not stable at some wind")
    return spot


@dataclass(slots=True)
class Climb:
    """A search that remembers its best spot.

    Attributes
    ----------
    history : what was accepted, the start first.
    refused : number of steps that were not taken.
    """

    family: LoopFamily
    aim: Objective
    spot: Spot
    reach: float = FIRST_REACH
    refused: int = 0
    history: list[Reached] = field(default_factory=list)
    _floor: float = 0.0
    _near: tuple[Moving, Moving, NDArray[np.bool_]] | None = None

    def __post_init__(self) -> None:
        self.history.append(self.spot.reached)
        self._floor = self.aim.kept * self.spot.reached.wind_error

    def stepped(self) -> bool:
        """Try one step; False where there is nothing more to gain."""
        spot = self.spot
        if self._near is None:
            self._near = self.family.moving(spot.theta, self.reach)
        windy, still, free = self._near
        least = np.log(self._floor / spot.reached.wind_error) - ROOM
        weights = replace(_weights(self.family, spot, self.aim), least=float(least))
        low, high = np.where(free, np.array([-self.reach, self.reach]), 0.0).T
        room = Room(low, high, self.family.bends(self.reach))
        found = joint_step(windy, still, spot.functions, _directions(self.family), weights, room)
        new = None
        if found is not None:
            new = self.assessed(spot.theta * np.exp(found.u), found.functions)
        lower = self._floor * (1 - 2 * ROOM)
        if new is None or new.value >= spot.value or new.reached.wind_error < lower:
            self.refused += 1
            self.reach *= NARROWER
            self._near = None
            return self.reach >= LEAST_REACH
        gained = spot.value - new.value
        self.spot, self._near = new, None
        self.history.append(new.reached)
        self.reach = min(self.reach * WIDER, LARGEST_REACH)
        return gained > ENOUGH

    def assessed(self, theta: Floats, functions: Functions) -> Spot | None:
        """Return the spot at other gains, enclosed anew; None where no function holds there."""
        try:
            windy, still = self.family.corners(theta)
        except ModelError:
            return None
        shown = borne(windy, still, functions, _limits(self.family))
        if shown is None or (self.aim.decay > 0 and not shown.decay_rate > 0):
            return None
        better = _settled(self.family, windy, still, shown, self.aim, AFTER_STEP, floor=self._floor)
        return _spot(self.family, theta, better, self.aim)


def resting(family: LoopFamily, spot: Spot) -> Spot:
    """Return the spot with the largest common decay rate at its gains, and the R that shows it."""
    _, still = family.corners(spot.theta)
    found = max_decay_rate(still.A)
    if found.P is None or found.decay_rate is None or found.decay_rate <= spot.functions.decay_rate:
        return spot
    R = np.asarray(found.P)
    decay = float(decay_rates(R, still.A).min())
    functions = replace(spot.functions, R=R, decay_rate=decay)
    return replace(spot, functions=functions, reached=replace(spot.reached, decay_rate=decay))


def _settled(
    family: LoopFamily,
    windy: Corners,
    still: Corners,
    functions: Functions,
    aim: Objective,
    most: int,
    *,
    floor: float = 0.0,
) -> Functions:
    """Return the functions improved with gains fixed.

    Parameters
    ----------
    floor : mean wind error [m/s] to be kept, or to be reached again; 0 for none.
    """
    directions, shares = _directions(family), _shares(family)
    value, mean = _function_value(family, functions, aim), _mean_error(family, functions)
    for _ in range(most):
        least = float(np.log(floor / mean)) if floor > 0 else None
        weights = Weights(
            aim.wind_class * shares, aim.overspeed, aim.decay, np.zeros(0), shares, least
        )
        found = joint_step(windy, still, functions, directions, weights)
        shown = None
        if found is not None:
            shown = borne(windy, still, found.functions, _limits(family))
        if shown is None or (aim.decay > 0 and not shown.decay_rate > 0):
            break
        after, kept = _function_value(family, shown, aim), _mean_error(family, shown)
        raised = mean < floor and kept > mean
        if after < value or raised:
            functions = shown
        if value - after < SETTLED and not raised:
            break
        value, mean = after, kept
    return functions


def _mean_error(family: LoopFamily, functions: Functions) -> float:
    """Return the geometric mean over wind of the wind error that P bears [m/s]."""
    return float(np.exp(_shares(family) @ np.log(functions.scales * family.error)))


def _function_value(family: LoopFamily, functions: Functions, aim: Objective) -> float:
    """Return the part of the objective that does not look at motion in turbulence."""
    peak = float(reach_of(functions.P, _directions(family)[:1])[0]) ** 0.5
    value = -aim.wind_class * float(_shares(family) @ np.log(functions.scales))
    if aim.decay > 0:
        value -= aim.decay * np.log(functions.decay_rate)
    return value + aim.overspeed * float(np.log(peak))


def _spot(family: LoopFamily, theta: Floats, functions: Functions, aim: Objective) -> Spot | None:
    """Return what is reached; None where the linear loop about a trim is not stable."""
    peak = float(reach_of(functions.P, _directions(family)[:1])[0]) ** 0.5
    share = _shares(family)
    pitch = tower = np.nan
    value = _function_value(family, functions, aim)
    if aim.watches_motion:
        moved = motion(family.turbine, family.at(theta))
        pitch, tower = float(share @ moved.pitch_rate), float(share @ moved.tower_speed)
        value += aim.pitch * np.log(pitch) + aim.tower * np.log(tower)
    reached = Reached(
        _mean_error(family, functions),
        float(family.box.speed_error) * peak,
        functions.decay_rate if functions.decay_rate > 0 else np.nan,
        pitch,
        tower,
    )
    return Spot(theta, functions, reached, float(value)) if np.isfinite(value) else None


def _weights(family: LoopFamily, spot: Spot, aim: Objective) -> Weights:
    gains = np.zeros(len(spot.theta))
    if aim.watches_motion:
        gains = _motion_slopes(family, spot, aim)
    shares = _shares(family)
    return Weights(aim.wind_class * shares, aim.overspeed, aim.decay, gains, shares)


def _motion_slopes(family: LoopFamily, spot: Spot, aim: Objective) -> Floats:
    """Return d (weighed logarithms of pitch rate and tower speed) / d (logarithms of the gains)."""
    nodes, step = family.cells + 1, 1e-2
    share = _shares(family)
    slopes = np.zeros(len(spot.theta))
    faster = [spot.theta.copy(), spot.theta.copy()]
    faster[0][:nodes] *= np.exp(step)
    faster[1][nodes:] *= np.exp(step)
    here = motion(family.turbine, family.at(spot.theta))
    for part, theta in enumerate(faster):
        there = motion(family.turbine, family.at(theta))
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


def _shares(family: LoopFamily) -> Floats:
    widths = np.diff(family.law.schedule.wind)
    return np.asarray(widths / widths.sum(), dtype=np.float64)


def _limits(family: LoopFamily) -> Floats:
    """Return (K - 1,): the multiple of the wind error up to which the cells are enclosed."""
    wind = family.law.schedule.wind[:-1]
    return np.asarray(float(family.box.wind_share) * wind / family.error, dtype=np.float64)


def _directions(family: LoopFamily) -> Floats:
    """Return rows h_i with |h_i' x| <= 1 on the box: speed error, effort lag, speed signal."""
    box = family.box
    e, z, y = (float(b) for b in (box.speed_error, box.effort_lag, box.speed_signal))
    return np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]])
