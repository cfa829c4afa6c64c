"""The search for better gains: the loop is enclosed again after each step before it is accepted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, invariant_ellipsoid
from takagi.lmi.turbine.one_step.joint_step import RemainingRoom, Weights, joint_step
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    LoopOfGains,
    MovingCorners,
    WindCellCorners,
    functions_at,
)
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.lmi.turbine.one_step.value import (
    DesignPoint,
    ReachedValues,
    design_point,
    function_value,
    mean_error,
    shares_of,
    weights_at,
    widest_multiples,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Radius of the trust region, for the logarithm of each gain: at the start, the largest, and the
# radius below which the search ends.
FIRST_REACH, LARGEST_REACH, LEAST_REACH = 0.1, 0.2, 0.01
WIDER, NARROWER = 1.5, 0.3
# The search for functions at fixed gains stops below the first relative improvement of the
# objective, and the search for gains below the second.
SETTLED, ENOUGH = 3e-3, 1e-3
# Relative amount by which a step may miss the mean wind error that is to be kept.  Without it the
# feasible set of the LMIs may have no interior, which interior-point solvers need.
ROOM = 1e-3
# Largest number of improvements of the functions at fixed gains, at the start and after a step.
AT_START, AFTER_STEP = 8, 1
NO_WIND = "in some cell of wind speeds the loop tolerates no error of the wind estimate"


def first_point(loop: LoopOfGains, theta: Floats, aim: Objective) -> DesignPoint:
    """Return the point at given gains; its functions are found without a first guess.

    Raises
    ------
    ModelError : no function was found; the message says what to change.
    """
    windy, still = loop.corners(theta)
    directions = loop.box.directions
    nu = theta[loop.cells + 1 :]
    d = windy.fixed + windy.error
    first = invariant_ellipsoid(windy.A, d, windy.cell, directions, speed=nu[windy.cell], rounds=5)
    rest = fast_decay(still.A)
    functions = None
    if first.P is not None and rest.P is not None:
        none = np.zeros(loop.cells)
        given = LoopFunctions(np.asarray(first.P), none, none, np.asarray(rest.P), 0.0)
        functions = functions_at(windy, still, given, widest_multiples(loop))
    if functions is None:
        raise ModelError(
            "one-step design: the gains it starts from have no common quadratic function under "
            f"these wind limits ({first.diagnosis or rest.diagnosis or NO_WIND})"
            "; narrow the wind limits, the uncertainty or the box, or change the bandwidth"
        )
    # The first function maximises the wind class, whatever the objective is, because later steps
    # must keep a share of the wind class of this start.
    opening = replace(aim, wind_class=max(aim.wind_class, 1.0), decay=0.0)
    # ``invariant_ellipsoid`` maximises the multiple of the weakest cell, so this is the best floor.
    floor = float(functions.scales.min())
    functions = _settled(loop, windy, still, functions, opening, AT_START, kept=_Kept(0.0, floor))
    spot = design_point(loop, theta, functions, aim)
    if spot is None:
        raise ModelError("one-step design: the linear loop at the start is not stable at some wind")
    return replace(spot, floor=floor)


@dataclass(frozen=True, slots=True)
class _Kept:
    """Lower limits that every accepted step respects.

    Attributes
    ----------
    mean : least mean wind error [m/s]; 0 sets no limit.
    multiple : least multiple of the wind error in the weakest cell.
    """

    mean: float
    multiple: float

    def lost_by(self, spot: DesignPoint) -> bool:
        lower = 1 - 2 * ROOM
        return (
            spot.reached.wind_error < self.mean * lower
            or float(spot.functions.scales.min()) < self.multiple * lower
        )


@dataclass(slots=True)
class Iteration:
    """State of the search; ``spot`` is the best point so far.

    Attributes
    ----------
    reach : radius of the trust region, in the logarithms of the gains.
    history : values of each accepted point; the first entry is the start.
    refused : number of steps that were not accepted.
    """

    loop: LoopOfGains
    aim: Objective
    spot: DesignPoint
    reach: float = FIRST_REACH
    refused: int = 0
    history: list[ReachedValues] = field(default_factory=list)
    _kept: _Kept = field(init=False)
    _near: tuple[MovingCorners, MovingCorners, NDArray[np.bool_]] | None = None

    def __post_init__(self) -> None:
        self.history.append(self.spot.reached)
        kept, spot = self.aim.kept, self.spot
        self._kept = _Kept(kept * spot.reached.wind_error, kept * spot.floor)

    def stepped(self) -> bool:
        """Try one step; return False if the search has ended."""
        spot = self.spot
        if self._near is None:
            self._near = self.loop.moving(spot.theta, self.reach)
        windy, still, free = self._near
        least = np.log(self._kept.mean / spot.reached.wind_error) - ROOM
        weights = replace(
            weights_at(self.loop, spot, self.aim),
            least=float(least),
            floors=np.full(self.loop.cells, self._kept.multiple),
        )
        low, high = np.where(free, np.array([-self.reach, self.reach]), 0.0).T
        room = RemainingRoom(low, high, self.loop.bends(self.reach))
        found = joint_step(windy, still, spot.functions, self.loop.box.directions, weights, room)
        new = None
        if found is not None:
            new = self.assessed(spot.theta * np.exp(found.u), found.functions)
        if new is None or new.value >= spot.value or self._kept.lost_by(new):
            self.refused += 1
            # A refused step means that the linearisation was used too far from its point.
            self.reach *= NARROWER
            self._near = None
            return self.reach >= LEAST_REACH
        gained = spot.value - new.value
        self.spot, self._near = new, None
        self.history.append(new.reached)
        self.reach = min(self.reach * WIDER, LARGEST_REACH)
        return gained > ENOUGH

    def assessed(self, theta: Floats, functions: LoopFunctions) -> DesignPoint | None:
        """Return the point at other gains, with new enclosures; None if no function holds there."""
        try:
            windy, still = self.loop.corners(theta)
        except ModelError:
            return None
        shown = functions_at(windy, still, functions, widest_multiples(self.loop))
        if shown is None or (self.aim.decay > 0 and not shown.decay_rate > 0):
            return None
        better = _settled(self.loop, windy, still, shown, self.aim, AFTER_STEP, kept=self._kept)
        spot = design_point(self.loop, theta, better, self.aim)
        return None if spot is None else replace(spot, floor=self._kept.multiple)


def with_largest_decay_rate(loop: LoopOfGains, spot: DesignPoint) -> DesignPoint:
    """Return the point with the largest common decay rate at its gains, and the R that has it."""
    _, still = loop.corners(spot.theta)
    found = fast_decay(still.A)
    if found.P is None or found.decay_rate is None or found.decay_rate <= spot.functions.decay_rate:
        return spot
    R = np.asarray(found.P)
    decay = float(decay_rates(R, still.A).min())
    functions = replace(spot.functions, R=R, decay_rate=decay)
    return replace(spot, functions=functions, reached=replace(spot.reached, decay_rate=decay))


def _settled(
    loop: LoopOfGains,
    windy: WindCellCorners,
    still: WindCellCorners,
    functions: LoopFunctions,
    aim: Objective,
    most: int,
    *,
    kept: _Kept,
) -> LoopFunctions:
    """Return the functions after at most ``most`` improvements at fixed gains.

    Parameters
    ----------
    kept : lower limits; functions below them are first raised towards them.
    """
    directions, shares = loop.box.directions, shares_of(loop)
    value, mean = function_value(loop, functions, aim), mean_error(loop, functions)
    floors = np.full(loop.cells, kept.multiple)
    for _ in range(most):
        least = float(np.log(kept.mean / mean)) if kept.mean > 0 else None
        weights = Weights(
            aim.wind_class * shares, aim.overspeed, aim.decay, np.zeros(0), shares, least, floors
        )
        found = joint_step(windy, still, functions, directions, weights)
        shown = None
        if found is not None:
            shown = functions_at(windy, still, found.functions, widest_multiples(loop))
        if shown is None or (aim.decay > 0 and not shown.decay_rate > 0):
            break
        after, reached = function_value(loop, shown, aim), mean_error(loop, shown)
        # Progress towards a limit counts as success, even if the objective became worse by it.
        raised = (mean < kept.mean and reached > mean) or (
            float(functions.scales.min()) < min(kept.multiple, float(shown.scales.min()))
        )
        if after < value or raised:
            functions = shown
        if value - after < SETTLED and not raised:
            break
        value, mean = after, reached
    return functions
