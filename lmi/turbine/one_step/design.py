"""Gains of the effort-sharing law at all winds and the loop's quadratic functions, found together.

The two-step design finds the gains at each wind separately and searches for one Lyapunov function
afterwards.  The one-step design starts from the two-step gains and changes all unknowns together:
the gains gamma (one for each node) and nu (one for each cell), the function P with its invariant
set {x' P x <= 1} under the wind class, the multipliers of P, and the function R of the common decay
rate.  Each step has three parts:

1. the loop is enclosed at the present gains and at neighbouring gains (``loop_of_gains``);
2. one convex step changes functions and gains (``joint_step``) within a trust region;
3. the loop is enclosed again at the new gains, and the functions are improved there with gains
   fixed.  The step is accepted if the objective at these enclosures became smaller; otherwise the
   trust region shrinks.

The objective therefore never becomes worse, even where the linearisation of step 2 is inaccurate.
The parameters keep the law's structure: the torque law depends on speed and integral alone, and
the ramp shares one effort between torque and pitch.  Actuator limits are part of the enclosure.  It
refuses gains for which a state in the set would command negative torque, pitch beyond its limit, or
a pitch lead faster than the pitch rate limit.  The pitch rate limit itself enters as a sector.

The result is a design in floating point and no proof; the certificate decides about it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, invariant_ellipsoid
from takagi.lmi.turbine.one_step.design_point import (
    DesignPoint,
    Objective,
    ReachedValues,
    design_point,
    function_value,
    mean_error,
    weights_at,
    widest_multiples,
)
from takagi.lmi.turbine.one_step.joint_step import joint_step
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    LoopOfGains,
    MovingCorners,
    WindCellCorners,
    functions_at,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw

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
    windy, calm = loop.corners(theta)
    directions = loop.box.directions
    nu = theta[loop.cells + 1 :]
    d = windy.fixed + windy.error
    first = invariant_ellipsoid(windy.A, d, windy.cell, directions, speed=nu[windy.cell], rounds=5)
    calm_answer = fast_decay(calm.A)
    functions = None
    if first.P is not None and calm_answer.P is not None:
        none = np.zeros(loop.cells)
        first_guess = LoopFunctions(np.asarray(first.P), none, none, np.asarray(calm_answer.P), 0.0)
        functions = functions_at(windy, calm, first_guess, widest_multiples(loop))
    if functions is None:
        raise ModelError(
            "one-step design: the gains it starts from have no common quadratic function under "
            f"these wind limits ({first.diagnosis or calm_answer.diagnosis or NO_WIND})"
            "; narrow the wind limits, the uncertainty or the box, or change the bandwidth"
        )
    # The first function maximises the wind class, whatever the objective is, because later steps
    # must keep a share of the wind class of this start.
    opening = replace(aim, wind_class=max(aim.wind_class, 1.0), decay=0.0)
    # ``invariant_ellipsoid`` maximises the multiple of the weakest cell, so this is the best floor.
    floor = float(functions.scales.min())
    functions = _settled(loop, windy, calm, functions, opening, AT_START, least=(0.0, floor))
    return replace(design_point(loop, theta, functions, aim), floor=floor)


@dataclass(slots=True)
class Iteration:
    """State of the search; ``spot`` is the best point so far.

    Attributes
    ----------
    reach : radius of the trust region, in the logarithms of the gains.
    history : values of each accepted point; the first entry is the start.
    least : lower limits that every accepted step respects, of the mean wind error [m/s] and of the
        multiple of the wind error in the weakest cell.
    refused : number of steps that were not accepted.
    """

    loop: LoopOfGains
    aim: Objective
    spot: DesignPoint
    reach: float = FIRST_REACH
    refused: int = 0
    history: list[ReachedValues] = field(default_factory=list)
    least: tuple[float, float] = field(init=False)
    _near: tuple[MovingCorners, MovingCorners, NDArray[np.bool_]] | None = None

    def __post_init__(self) -> None:
        self.history.append(self.spot.reached)
        share, spot = self.aim.kept, self.spot
        self.least = share * spot.reached.wind_error, share * spot.floor

    def stepped(self) -> bool:
        """Try one step; return False if the search has ended."""
        spot = self.spot
        if self._near is None:
            self._near = self.loop.moving(spot.theta, self.reach)
        windy, calm, free = self._near
        mean, multiple = self.least
        log_mean = float(np.log(mean / spot.reached.wind_error) - ROOM)
        weights = weights_at(self.loop, self.aim, log_mean=log_mean, floor=multiple)
        low, high = np.where(free, np.array([-self.reach, self.reach]), 0.0).T
        room = low, high, self.loop.bends(self.reach)
        step = joint_step(windy, calm, spot.functions, self.loop.box.directions, weights, room)
        new = None if step is None else self.assessed(spot.theta * np.exp(step[0]), step[1])
        lower = 1 - 2 * ROOM
        if (
            new is None
            or new.value >= spot.value
            or new.reached.wind_error < mean * lower
            or float(new.functions.scales.min()) < multiple * lower
        ):
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
            windy, calm = self.loop.corners(theta)
        except ModelError:
            return None
        functions_there = functions_at(windy, calm, functions, widest_multiples(self.loop))
        if functions_there is None or (self.aim.decay > 0 and not functions_there.decay_rate > 0):
            return None
        better = _settled(
            self.loop, windy, calm, functions_there, self.aim, AFTER_STEP, least=self.least
        )
        return replace(design_point(self.loop, theta, better, self.aim), floor=self.least[1])


def with_largest_decay_rate(loop: LoopOfGains, spot: DesignPoint) -> DesignPoint:
    """Return the point with the largest common decay rate at its gains, and the R that has it."""
    _, calm = loop.corners(spot.theta)
    answer = fast_decay(calm.A)
    if (
        answer.P is None
        or answer.decay_rate is None
        or answer.decay_rate <= spot.functions.decay_rate
    ):
        return spot
    R = np.asarray(answer.P)
    decay = float(decay_rates(R, calm.A).min())
    functions = replace(spot.functions, R=R, decay_rate=decay)
    return replace(spot, functions=functions, reached=replace(spot.reached, decay_rate=decay))


def _settled(
    loop: LoopOfGains,
    windy: WindCellCorners,
    calm: WindCellCorners,
    functions: LoopFunctions,
    aim: Objective,
    step_count: int,
    *,
    least: tuple[float, float],
) -> LoopFunctions:
    """Return the functions after at most ``step_count`` improvements at fixed gains.

    ``least`` : lower limits, as of an ``Iteration``; functions below them are first raised.
    """
    directions, (least_mean, multiple) = loop.box.directions, least
    value, mean = function_value(loop, functions, aim), mean_error(loop, functions)
    for _ in range(step_count):
        log_mean = float(np.log(least_mean / mean)) if least_mean > 0 else None
        weights = weights_at(loop, aim, log_mean=log_mean, floor=multiple)
        step = joint_step(windy, calm, functions, directions, weights)
        new_functions = None
        if step is not None:
            new_functions = functions_at(windy, calm, step[1], widest_multiples(loop))
        if new_functions is None or (aim.decay > 0 and not new_functions.decay_rate > 0):
            break
        new_value, reached = (
            function_value(loop, new_functions, aim),
            mean_error(loop, new_functions),
        )
        # Progress towards a limit counts as success, even if the objective became worse by it.
        raised = (mean < least_mean and reached > mean) or (
            float(functions.scales.min()) < min(multiple, float(new_functions.scales.min()))
        )
        if new_value < value or raised:
            functions = new_functions
        if value - new_value < SETTLED and not raised:
            break
        value, mean = new_value, reached
    return functions


Tell = Callable[[str], None]

STEPS = 12


@dataclass(frozen=True, slots=True, eq=False)
class OneStepDesign:
    """Gains and functions of the one-step design, and a comparison with the two-step gains.

    Attributes
    ----------
    law : law with the gains, rounded to the decimals that are emitted.
    functions : P with its multipliers, and R, at these gains.
    before, after : values of the two-step gains and of the new gains, by the same analysis.
    history : values after each accepted step; the first entry is the start.
    refused : number of steps that were not accepted.
    """

    law: EffortSharingLaw
    functions: LoopFunctions
    before: ReachedValues
    after: ReachedValues
    history: tuple[ReachedValues, ...]
    refused: int

    @property
    def gains(self) -> EffortGains:
        return self.law.gains


def one_step_gains(
    loop: LoopOfGains,
    *,
    objective: Objective | None = None,
    steps: int = STEPS,
    tell: Tell | None = None,
) -> OneStepDesign:
    """Return gains and functions found together, starting from the gains of ``loop.law``.

    Parameters
    ----------
    loop : loop, box, uncertainty and wind class; the gains of its law are the two-step gains.
    objective : weights of the objective; None maximises the wind class alone.
    steps : largest number of joint steps, accepted or not; 0 only analyses the given gains.
    tell : called with a line of text before each step.

    Raises
    ------
    ModelError : no function was found at the given gains, or ``steps`` is below 0.
    """
    if steps < 0:
        raise ModelError(f"steps = {steps} was given; 0 or more are needed")
    say = tell or (lambda text: None)
    aim = objective or Objective()
    say("analysing the gains found wind by wind")
    gains = loop.law.gains
    spot = first_point(loop, np.concatenate([gains.proportional, gains.integral_rate]), aim)
    iteration = Iteration(loop, aim, spot)
    for count in range(steps):
        say(f"joint step {count + 1} of {steps}")
        if not iteration.stepped():
            break
    theta = iteration.spot.theta
    nodes = loop.cells + 1
    rounded = np.concatenate([np.round(theta[:nodes], 5), np.round(theta[nodes:], 6)])
    # The rounded gains are the ones that are emitted, so they are assessed again.  If rounding
    # makes the objective worse than at the start, the starting gains are returned.
    last = iteration.assessed(rounded, iteration.spot.functions)
    best = with_largest_decay_rate(loop, spot if last is None or last.value >= spot.value else last)
    law = replace(loop.law, gains=loop.at(best.theta).gains)
    return OneStepDesign(
        law, best.functions, spot.reached, best.reached, tuple(iteration.history), iteration.refused
    )
