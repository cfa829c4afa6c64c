r"""Gains of the effort-sharing law at all winds and the loop's quadratic functions, found together.

The two-step design finds the gains at each wind separately and searches for one Lyapunov function
afterwards.  The one-step design starts from the two-step gains and changes all unknowns together:
the gains gamma (one for each node) and nu (one for each cell), the function P with its invariant
set {x' P x <= 1} under the wind class, the multipliers of P, and the function R of the common decay
rate.  Each step has three parts:

1. the loop is enclosed at the present gains and at neighbouring gains (``loop_of_gains``);
2. one convex step changes functions and gains (``condition``) within a trust region;
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
from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.turbine.one_step.iteration import Iteration, first_point, with_largest_decay_rate
from takagi.lmi.turbine.one_step.loop_of_gains import LoopFunctions, LoopOfGains
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.lmi.turbine.one_step.value import ReachedValues
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw

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
    say = tell or _silent
    aim = objective or Objective()
    say("analysing the gains found wind by wind")
    spot = first_point(loop, _theta(loop.law), aim)
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


def _theta(law: EffortSharingLaw) -> Floats:
    return np.concatenate([law.gains.proportional, law.gains.integral_rate])


def _silent(_: str) -> None:
    """Ignore the line of text."""
