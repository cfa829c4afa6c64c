r"""Gains of the coherent law at all winds and the quadratic functions of the loop, found together.

The two-step design finds gains wind by wind and looks for one function afterwards.  Here the
gains gamma (nodes) and nu (cells), the function P with its invariant set {x' P x <= 1} under the
wind class, its multipliers and the function R of the common decay rate move at once, from the
two-step gains on:

1. the loop is enclosed at the present gains and beside them (``loop_of_gains``);
2. one convex step moves functions and gains (``condition``), within a trust region;
3. the loop is enclosed anew at the new gains, the functions are improved there with gains fixed,
   and the step is taken if the objective, at these true enclosures, became smaller; if not, the
   trust region shrinks.

So nothing is lost on the way, whatever the straight lines of step 2 miss.  The law's structure is
kept by construction: torque sees speed and integral alone, one effort is shared by the ramp.
Actuator limits are part of the enclosure: gains whose set could ask for negative torque, pitch
beyond its limit, or a lead beyond the pitch rate, are refused there, and the pitch rate limit
enters as a sector.

What is found is floating point: a design, not a proof.  The certificate proves it or not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.turbine.one_step.iteration import Iteration, first_point, with_largest_decay_rate
from takagi.lmi.turbine.one_step.loop_functions import LoopFunctions
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.lmi.turbine.one_step.value import ReachedValues
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw

Tell = Callable[[str], None]

STEPS = 12


@dataclass(frozen=True, slots=True, eq=False)
class OneStepDesign:
    """Gains and functions found together, and what that gained.

    Attributes
    ----------
    law : with the gains, rounded to the decimals that are emitted.
    functions : P with its multipliers and R, at these gains.
    before, after : what the two-step gains reach, and these; by the same analysis.
    history : what each accepted step reached, the start first.
    refused : number of steps that were not taken.
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
    family: LoopOfGains,
    *,
    objective: Objective | None = None,
    steps: int = STEPS,
    tell: Tell | None = None,
) -> OneStepDesign:
    """Return gains and functions found together, from the gains of ``family.law`` on.

    Parameters
    ----------
    family : loop, box, uncertainty and wind class; the law's gains are the two-step ones.
    objective : what is made better; None takes the wind class alone.
    steps : most joint steps, accepted or not; 0 only analyses the gains that are given.
    tell : called with a word before each step.

    Raises
    ------
    ModelError : no function at the gains that are given, or a count below 0.
    """
    if steps < 0:
        raise ModelError(f"steps = {steps} was given; 0 or more are needed")
    say = tell or _silent
    aim = objective or Objective()
    say("analysing the gains found wind by wind")
    spot = first_point(family, _theta(family.law), aim)
    climb = Iteration(family, aim, spot)
    for count in range(steps):
        say(f"joint step {count + 1} of {steps}")
        if not climb.stepped():
            break
    theta = climb.spot.theta
    nodes = family.cells + 1
    rounded = np.concatenate([np.round(theta[:nodes], 5), np.round(theta[nodes:], 6)])
    # Rounding moves the loop by less than a step does; where it loses more, the start remains.
    last = climb.assessed(rounded, climb.spot.functions)
    best = with_largest_decay_rate(
        family, spot if last is None or last.value >= spot.value else last
    )
    law = replace(family.law, gains=family.at(best.theta).gains)
    return OneStepDesign(
        law, best.functions, spot.reached, best.reached, tuple(climb.history), climb.refused
    )


def effort_loop_reach(family: LoopOfGains, objective: Objective | None = None) -> ReachedValues:
    """Return what the gains of ``family.law`` reach, by the analysis of ``one_step_gains``.

    Raises
    ------
    ModelError : no function at these gains.
    """
    return first_point(family, _theta(family.law), objective or Objective()).reached


def _theta(law: EffortSharingLaw) -> Floats:
    return np.concatenate([law.gains.proportional, law.gains.integral_rate])


def _silent(_: str) -> None:
    """Say nothing."""
