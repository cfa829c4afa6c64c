"""The effort-sharing law's gains and its claim's candidate, found together or one after the other.

Two-step: gains wind by wind, then the quadratic functions of the loop.  One-step: from there,
gains and functions together (``lmi.turbine.one_step``).  If this finds nothing better, or its
result does not hold for the enclosed loop of the claim, the two-step design is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import (
    EffortSharingCandidate,
    WindClass,
    enclosures_of_gains,
)
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    larger_least_pitch,
    smaller_uncertainty,
    why_not_proved,
)
from takagi.certificates.design.design import StepClock, Tell
from takagi.certificates.design.turbine.settings import DesignSettings, Synthesis
from takagi.lmi.turbine.one_step.design import STEPS, OneStepDesign, one_step_gains
from takagi.lmi.turbine.one_step.design_point import Objective
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import (
    EffortSharingLaw,
    LoopBox,
    LoopUncertainty,
    SetpointInputs,
)
from takagi.models.laws.effort_sharing.schedule import EffortSchedule, effort_schedule, speed_effort
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign
    from takagi.models.ts.model import TSModel
    from takagi.models.turbine.wind_observer import WindObserver


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingGainDesign:
    """Law, candidate, and the improvement by the joint search.

    Attributes
    ----------
    law : with the gains that are emitted;  candidate : of the claim about it.
    joint : the result of the joint search, with both sets of gains assessed by the same analysis;
        None if it was not requested, or for the reason in ``kept``.
    kept : why the two-step design was kept although the other was requested; else empty.
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
    remade: Callable[[Turbine], EffortSharingLaw] | None = None,
    tell: Tell | None = None,
) -> EffortSharingGainDesign:
    """Return gains and candidate of the loop; the search starts at the gains of ``law``.

    Parameters
    ----------
    law : with gains found wind by wind (``effort_gains``).
    synthesis : "one-step" changes them together with the functions; "two-step" keeps them.
    objective : what the joint search improves; None takes the wind class.
    steps : the largest number of joint steps.
    remade : returns the law of a turbine with another smallest pitch, which is tried where winds
        are not proved; None tries none.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : no function for the gains of ``law``, or none that covers all winds, with what
        would do; or a box that exceeds tables or limits.  Names the wind.
    """
    say = StepClock(tell).told
    first = effort_sharing_candidate(turbine, law, box=box, uncertainty=uncertainty, tell=say)
    if first.P is not None and why_not_proved(first):
        first = widened(turbine, law, first, tell=say)
    if why := why_not_proved(first):
        say("joint analysis of smaller uncertainties")
        remedies = [smaller_uncertainty(turbine, law, box, uncertainty)]
        if remade is not None:
            say("joint analysis with a larger smallest pitch")
            remedies.append(larger_least_pitch(turbine, remade, box, uncertainty))
        tried = "; ".join(filter(None, remedies)) or (
            "less uncertainty of the inertia, no frozen wake and a larger smallest pitch were tried"
        )
        raise ModelError(
            f"joint analysis: {why}. Reduce the uncertainty or the box, or change the bandwidth; "
            f"{tried}"
        )
    if synthesis == "two-step":
        return EffortSharingGainDesign(law, widened(turbine, law, first, tell=say), None, "")
    loop = _loop_of(turbine, law, first)
    try:
        joint = one_step_gains(loop, objective=objective, steps=steps, tell=say)
        reason = f"none of {joint.refused} joint steps made the objective better"
    except ModelError as error:
        joint, reason = None, str(error)
    if joint is not None and len(joint.history) > 1:
        better = _stated(turbine, first, joint, say)
        if better is not None:
            return EffortSharingGainDesign(joint.law, better, joint, "")
        reason = "the gains found together do not hold on the exactly enclosed loop"
    return EffortSharingGainDesign(law, widened(turbine, law, first, tell=say), None, reason)


def widened(
    turbine: Turbine,
    law: EffortSharingLaw,
    first: EffortSharingCandidate,
    *,
    tell: Tell | None = None,
) -> EffortSharingCandidate:
    """Return a candidate with the same gains that allows larger wind errors, if one is found.

    ``first`` has a P; its box, uncertainty and wind rates are kept.
    """
    say, loop = StepClock(tell).told, _loop_of(turbine, law, first)
    try:
        joint = one_step_gains(loop, steps=0, tell=say)
    except ModelError:
        # That search needs a function with a wind error above 0 in every cell. If there is none,
        # the first candidate is kept.
        return first
    wider = _stated(turbine, first, joint, say)
    return wider if wider is not None and _mean(law, wider) > _mean(law, first) else first


def _loop_of(turbine: Turbine, law: EffortSharingLaw, first: EffortSharingCandidate) -> LoopOfGains:
    rates = [cell.wind_rate for cell in first.cells]
    return loop_of_gains(turbine, law, box=first.box, uncertainty=first.uncertainty, rates=rates)


def loop_of_gains(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    rates: Sequence[Fraction],
) -> LoopOfGains:
    """Return the loop as a function of its gains, with the default proportions of wind errors.

    ``rates`` : |v_s'| of each cell [m/s^2].
    """
    nodes, shape = law.schedule.wind, WindClass()
    return LoopOfGains(
        turbine=turbine,
        law=law,
        box=box,
        error=np.interp((nodes[1:] + nodes[:-1]) / 2, shape.wind, shape.error),
        enclosed=enclosures_of_gains(turbine, law, box, uncertainty, rates),
    )


def _stated(
    turbine: Turbine, first: EffortSharingCandidate, joint: OneStepDesign, say: Tell
) -> EffortSharingCandidate | None:
    """Return the candidate for the found gains and function; None if it does not hold."""
    try:
        candidate = effort_sharing_candidate(
            turbine,
            joint.law,
            box=first.box,
            uncertainty=first.uncertainty,
            P=np.asarray(joint.functions.P),
            rates=[cell.wind_rate for cell in first.cells],
            tell=say,
        )
    except ModelError:
        # Rounded gains may leave a table or a limit that those of the search just met.
        return None
    return candidate if candidate.P is not None and candidate.wind_error.min() > 0 else None


def _mean(law: EffortSharingLaw, candidate: EffortSharingCandidate) -> float:
    """Return the mean over wind of the logarithm of the admissible wind errors."""
    widths = np.diff(law.schedule.wind)
    return float(widths @ np.log(np.maximum(candidate.wind_error, 1e-9)) / widths.sum())


OBSERVER_DECAY = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class ObserverDesign:
    """The wind observer: its error model, its gains, and the value that runs in a simulation.

    Attributes
    ----------
    model : Takagi-Sugeno error system in the unmeasured premise dT_r/dv / J.
    gains : (l_1 [1/s], l_2 [m/s per rad]).
    decay_rate : the rate at which the error decays in constant wind [1/s].
    observer : the observer that a simulation runs.
    """

    model: TSModel
    gains: tuple[float, float]
    decay_rate: float
    observer: WindObserver


def wind_observer_design(turbine: Turbine, settings: DesignSettings) -> ObserverDesign:
    """Return the wind observer with one gain for all winds.

    Raises
    ------
    ModelError : winds at which more wind does not give more torque, or no such gain.
    """
    from takagi.lmi.gains.observer import observer
    from takagi.models.turbine.wind_observer import WindObserver, wind_observer_model

    model = wind_observer_model(turbine, speed_setpoint=settings.speed_setpoint)
    design = observer(model, decay_rate=OBSERVER_DECAY, relaxation="common-gain")
    if design.gains is None:
        raise ModelError(f"wind observer: {design.answer.diagnosis}")
    l1, l2 = (round(float(gain), 4) for gain in design.gains[0, :, 0])
    return ObserverDesign(model, (l1, l2), OBSERVER_DECAY, WindObserver(turbine, l1, l2))


def wind_by_wind_law(
    turbine: Turbine, settings: DesignSettings
) -> tuple[EffortDesign, EffortSharingLaw]:
    """Return the effort-sharing law with gains found wind by wind, and what they were found for.

    Raises
    ------
    ModelError : no trim or no gain at some wind; names it.
    """
    from takagi.lmi.turbine.effort import effort_gains

    schedule = effort_schedule(
        turbine,
        overlap=settings.overlap,
        effectiveness_share=settings.effectiveness_share,
        speed_setpoint=settings.speed_setpoint,
    )
    effort = effort_gains(turbine, schedule, settings.effort)
    law = EffortSharingLaw.of(turbine, schedule, effort.gains, wind_filter=settings.wind_filter)
    return effort, replace(law, setpoints=_setpoint_inputs(turbine, schedule, settings))


def _setpoint_inputs(
    turbine: Turbine, schedule: EffortSchedule, settings: DesignSettings
) -> SetpointInputs | None:
    """Return the set-points that the law takes at run time; None where none are asked for."""
    speed, torque = settings.lowest_speed_setpoint, settings.lowest_torque_setpoint
    if speed is None and torque is None:
        return None
    torque = turbine.rated_torque if torque is None else torque
    derated(turbine, torque, speed_setpoint=settings.speed_setpoint)
    speed = float(schedule.rotor_speed[-1]) if speed is None else speed
    return SetpointInputs(
        round(speed, 9),
        round(torque, 6),
        turbine.generator_efficiency * turbine.gear_ratio,
        speed_effort(turbine, schedule, speed),
    )
