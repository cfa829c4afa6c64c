"""The coherent law's gains and the candidate of its claim: found together, or one after the other.

Two-step: gains wind by wind, then the quadratic functions of the loop.  One-step: from there,
gains and functions together (``lmi.turbine.one_step``).  Where that finds nothing better, or what
it found does not hold on the loop as it is enclosed for the claim, the two-step design is kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np

from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_candidate
from takagi.certificates.claims.turbine.failing_winds import failing_winds
from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate
from takagi.certificates.claims.turbine.smaller_uncertainty import smaller_uncertainty
from takagi.certificates.claims.turbine.wind_class import WindClass
from takagi.certificates.design.step_clock import StepClock, Tell
from takagi.lmi.turbine.one_step.design import STEPS, OneStepDesign, one_step_gains
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.lmi.turbine.one_step.objective import Objective
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.loops.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.turbine.data import Turbine

Synthesis = Literal["one-step", "two-step"]
SYNTHESES: tuple[Synthesis, ...] = ("one-step", "two-step")


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingGainDesign:
    """Law, candidate, and what finding them together gained.

    Attributes
    ----------
    law : with the gains that are emitted;  candidate : of the claim about it.
    joint : what the joint search found, with what both sets of gains reach by the same analysis;
        None where there is none: it was not asked for, or ``kept`` says why.
    kept : why the two-step design was kept although the other was asked for; else empty.
    """

    law: EffortSharingLaw
    candidate: EffortSharingCandidate
    joint: OneStepDesign | None
    kept: str


def effort_sharing_gain_design(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    synthesis: Synthesis = "one-step",
    objective: Objective | None = None,
    steps: int = STEPS,
    tell: Tell | None = None,
) -> EffortSharingGainDesign:
    """Return gains and candidate of the coherent loop, from the gains of ``law`` on.

    Parameters
    ----------
    law : with gains found wind by wind (``effort_gains``).
    synthesis : "one-step" moves them together with the functions; "two-step" keeps them.
    objective : what the joint search makes better; None takes the wind class.
    steps : most joint steps.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : no function at the gains of ``law``, or a box beyond what is enclosed; names the
        wind.
    """
    say = StepClock(tell).told
    first = effort_sharing_candidate(turbine, law, box=box, uncertainty=uncertainty, tell=say)
    if first.P is None:
        say("joint analysis of smaller uncertainties")
        remedy = smaller_uncertainty(turbine, law, box, uncertainty)
        raise ModelError(
            "joint analysis: no common quadratic function over all winds was found; "
            f"{failing_winds(first.cells)}. Reduce the uncertainty or the box, or change the "
            "bandwidth" + (f"; {remedy}" if remedy else "")
        )
    if synthesis == "two-step":
        return EffortSharingGainDesign(law, widened(turbine, law, first, tell=say), None, "")
    family = _family(turbine, law, first)
    try:
        found = one_step_gains(family, objective=objective, steps=steps, tell=say)
        kept = f"none of {found.refused} joint steps made the objective better"
    except ModelError as error:
        found, kept = None, str(error)
    if found is not None and len(found.history) > 1:
        better = _stated(family, found, say)
        if better is not None:
            return EffortSharingGainDesign(found.law, better, found, "")
        kept = "the gains found together do not hold on the exactly enclosed loop"
    return EffortSharingGainDesign(law, widened(turbine, law, first, tell=say), None, kept)


def widened(
    turbine: Turbine,
    law: EffortSharingLaw,
    first: EffortSharingCandidate,
    *,
    tell: Tell | None = None,
) -> EffortSharingCandidate:
    """Return a candidate at the same gains whose function bears more wind, if one is found.

    Parameters
    ----------
    first : candidate with a P, whose box, uncertainty and wind rates are kept.
    tell : called with a word on progress.
    """
    say, family = StepClock(tell).told, _family(turbine, law, first)
    try:
        found = one_step_gains(family, steps=0, tell=say)
    except ModelError:
        # No function bears some error in every cell, as that search asks; the first one stays.
        return first
    wider = _stated(family, found, say)
    return wider if wider is not None and _mean(law, wider) > _mean(law, first) else first


def _family(turbine: Turbine, law: EffortSharingLaw, first: EffortSharingCandidate) -> LoopOfGains:
    rates = [cell.wind_rate for cell in first.cells]
    return loop_of_gains(turbine, law, box=first.box, uncertainty=first.uncertainty, rates=rates)


def loop_of_gains(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    rates: list[Fraction],
) -> LoopOfGains:
    """Return the loop as a function of its gains, with the default proportions of wind errors."""
    nodes, shape = law.schedule.wind, WindClass()
    return LoopOfGains(
        turbine=turbine,
        law=law,
        box=box,
        uncertainty=uncertainty,
        error=np.interp((nodes[1:] + nodes[:-1]) / 2, shape.wind, shape.error),
        rate=rates,
    )


def _stated(family: LoopOfGains, found: OneStepDesign, say: Tell) -> EffortSharingCandidate | None:
    """Return the candidate at the found gains and function; None where it does not hold."""
    rates = [Fraction(rate) for rate in family.rate]
    given = np.asarray(found.functions.P)
    try:
        candidate = effort_sharing_candidate(
            family.turbine,
            found.law,
            box=family.box,
            uncertainty=family.uncertainty,
            P=given,
            rates=rates,
            tell=say,
        )
    except ModelError:
        # The exact enclosure of a cell refuses gains that the search's took.
        return None
    return candidate if candidate.P is not None and candidate.wind_error.min() > 0 else None


def _mean(law: EffortSharingLaw, candidate: EffortSharingCandidate) -> float:
    """Return the mean over wind of the logarithm of the wind errors borne."""
    widths = np.diff(law.schedule.wind)
    return float(widths @ np.log(np.maximum(candidate.wind_error, 1e-9)) / widths.sum())
