"""From a turbine to a checked design: regional models, gains, law, observer, certificate.

The one place where the floors below meet: everything that leaves the house (gain file, report,
appendix, simulation) reads the ``TurbineDesign`` made here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.certificate import check_document
from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_BOX,
    DEFAULT_UNCERTAINTY,
    CoherentCandidate,
)
from takagi.certificates.claims.turbine.loop_claims import loop_document
from takagi.certificates.design.step_clock import StepClock
from takagi.certificates.design.turbine.effort_sharing_gains import (
    SYNTHESES,
    CoherentSynthesis,
    Synthesis,
    coherent_synthesis,
)
from takagi.lmi.turbine.one_step.objective import OBJECTIVES, Objective
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import DEFAULT_WIND_FILTER
from takagi.models.loops.effort_sharing.cells import LoopBox, Uncertainty
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.derating import derated

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign, EffortSettings
    from takagi.lmi.turbine.regional import RegionalGains
    from takagi.models.laws.effort_sharing.law import CoherentLaw
    from takagi.models.laws.protocol import Law
    from takagi.models.ramps.membership_ramp import Shape
    from takagi.models.ts.model import TSModel
    from takagi.models.turbine.wind_observer import WindObserver

__all__ = ["LAWS", "DesignSettings", "ObserverDesign", "TurbineDesign", "design_turbine"]

LAWS = ("coherent", "paper", "paper-two-integrators")
Tell = Callable[[str], None]

OBSERVER_DECAY = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSettings:
    """What is asked for; the defaults are those of the NREL 5-MW turbine.

    ``takagi.certificates.design.turbine.scale.default_settings`` carries them to another size.

    Attributes
    ----------
    law : "coherent", "paper" or "paper-two-integrators".
    overlap : eps of the effort ramp [rad/s^2] (coherent).
    speed_overlap : eps_omega of the coupling filter [rad/s] (paper laws).
    torque_overlap : eps_T of the coupling filter [N m] (paper laws).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.
    torque_setpoint : de-rated torque [N m, high-speed shaft]; None takes the rated torque.
    wind_filter : tau_f, of the coherent law's low-pass on the wind estimate [s].
    effectiveness_share : b of the coherent law over the frozen wake's pitch effectiveness [-].
    ramp_shape, ramp_placement : of the coupling filter in speed, see ``coupling_filter`` (paper).
    tracking_time : of the anti-windup [s] (paper-two-integrators).
    effort : what is asked of the coherent gains; None takes the defaults.
    synthesis : "one-step" finds the coherent gains together with the loop's quadratic functions;
        "two-step" finds them wind by wind, and the functions afterwards.
    objective : what the one-step synthesis makes better.
    box, uncertainty : what the coherent certificate covers.
    """

    law: str = "coherent"
    overlap: float = 0.01
    speed_overlap: float = 0.1
    torque_overlap: float = 2000.0
    speed_setpoint: float | None = None
    torque_setpoint: float | None = None
    wind_filter: float = DEFAULT_WIND_FILTER
    effectiveness_share: float = 0.6
    ramp_shape: Shape = "smooth"
    ramp_placement: float = 0.5
    tracking_time: float = 5.0
    effort: EffortSettings | None = None
    synthesis: Synthesis = "one-step"
    objective: Objective = OBJECTIVES["balanced"]
    box: LoopBox = DEFAULT_BOX
    uncertainty: Uncertainty = DEFAULT_UNCERTAINTY

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ModelError(f"law {self.law!r} was given; choose one of {', '.join(LAWS)}")
        if self.synthesis not in SYNTHESES:
            raise ModelError(
                f"synthesis {self.synthesis!r} was given; choose one of {', '.join(SYNTHESES)}"
            )
        for name in (
            "overlap",
            "speed_overlap",
            "torque_overlap",
            "wind_filter",
            "effectiveness_share",
            "tracking_time",
        ):
            if not getattr(self, name) > 0:
                raise ModelError(f"{name} = {getattr(self, name)!r} was given; it must be positive")


@dataclass(frozen=True, slots=True, eq=False)
class ObserverDesign:
    """The wind observer: its error model, gains, and the runtime value.

    Attributes
    ----------
    model : Takagi-Sugeno error system in the unmeasured premise dT_r/dv / J.
    gains : (l_1 [1/s], l_2 [m/s per rad]).
    decay_rate : at which the error decays for constant wind [1/s].
    observer : to run in a simulation.
    """

    model: TSModel
    gains: tuple[float, float]
    decay_rate: float
    observer: WindObserver


@dataclass(frozen=True, slots=True, eq=False)
class TurbineDesign:
    """A finished design.

    Attributes
    ----------
    law : as it is emitted and simulated.
    partial_load, full_load : the regional Takagi-Sugeno models (4 and 8 rules).
    regional : the regions' PDC gains of the paper's structure.
    effort : the coherent gains; None for the paper's laws.
    observer : wind observer.
    candidate : enclosures and P of the coherent loop; None for the paper's laws.
    document : the certificate as it is written.
    checked : what the independent checker says about it.
    seconds : step -> time it took.
    synthesis : what finding gains and functions together gained; None for the paper's laws.
    """

    turbine: Turbine
    settings: DesignSettings
    law: Law
    partial_load: TSModel
    full_load: TSModel
    regional: RegionalGains
    effort: EffortDesign | None
    observer: ObserverDesign
    candidate: CoherentCandidate | None
    document: Mapping[str, Any]
    checked: Checked
    seconds: Mapping[str, float] = field(default_factory=dict)
    synthesis: CoherentSynthesis | None = None

    @property
    def coherent(self) -> CoherentLaw | None:
        """The law where it is the coherent one, else None."""
        from takagi.models.laws.effort_sharing.law import CoherentLaw

        return self.law if isinstance(self.law, CoherentLaw) else None


def design_turbine(
    turbine: Turbine,
    settings: DesignSettings | None = None,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> TurbineDesign:
    """Return models, gains, law, observer and certificate of a turbine.

    Parameters
    ----------
    settings : None takes ``default_settings``, which suit the turbine's size.
    files : the data files the turbine was read from; the certificate records their SHA-256.
    tell : called with a word before each step.

    Raises
    ------
    ModelError : an infeasible requirement; names the condition, the wind and what to relax.
    """
    from takagi.certificates.design.turbine.scale import default_settings

    asked = settings or default_settings(turbine)
    turbine = derated(turbine, asked.torque_setpoint, speed_setpoint=asked.speed_setpoint)
    clock = StepClock(tell)
    models = _regions(turbine, asked, clock)
    with clock("wind observer"):
        observer = _observer(turbine, asked)
    if asked.law != "coherent":
        from takagi.certificates.design.turbine.published_law import paper_design

        return _bound(paper_design(turbine, asked, models, observer, files, clock))
    return _bound(_coherent(turbine, asked, models, observer, files, clock))


def _bound(design: TurbineDesign) -> TurbineDesign:
    """Return the design with a certificate that is bound to the whole gain file."""
    from takagi.certificates.controller.content import bound
    from takagi.certificates.controller.turbine_members import turbine_members

    return replace(design, document=bound(design.document, turbine_members(design)))


def _regions(
    turbine: Turbine, asked: DesignSettings, clock: StepClock
) -> tuple[TSModel, TSModel, RegionalGains]:
    from takagi.certificates.design.turbine.regions import regional_design

    return regional_design(turbine, speed_setpoint=asked.speed_setpoint, step=clock)


def _observer(turbine: Turbine, asked: DesignSettings) -> ObserverDesign:
    from takagi.lmi.gains.observer import observer
    from takagi.models.turbine.wind_observer import WindObserver, wind_observer_model

    model = wind_observer_model(turbine, speed_setpoint=asked.speed_setpoint)
    design = observer(model, decay_rate=OBSERVER_DECAY, relaxation="common-gain")
    if design.gains is None:
        raise ModelError(f"wind observer: {design.answer.diagnosis}")
    l1, l2 = (round(float(gain), 4) for gain in design.gains[0, :, 0])
    return ObserverDesign(model, (l1, l2), OBSERVER_DECAY, WindObserver(turbine, l1, l2))


def _coherent(
    turbine: Turbine,
    asked: DesignSettings,
    models: tuple[TSModel, TSModel, RegionalGains],
    observer: ObserverDesign,
    files: Sequence[Path],
    clock: StepClock,
) -> TurbineDesign:
    from takagi.lmi.turbine.effort import effort_gains
    from takagi.models.laws.effort_sharing.law import CoherentLaw
    from takagi.models.laws.effort_sharing.schedule import effort_schedule

    with clock("gains of the coherent law"):
        schedule = effort_schedule(
            turbine,
            overlap=asked.overlap,
            effectiveness_share=asked.effectiveness_share,
            speed_setpoint=asked.speed_setpoint,
        )
        effort = effort_gains(turbine, schedule, asked.effort)
        law = CoherentLaw.of(turbine, schedule, effort.gains, wind_filter=asked.wind_filter)
    with clock("joint analysis of the blended loop"):
        found = coherent_synthesis(
            turbine,
            law,
            box=asked.box,
            uncertainty=asked.uncertainty,
            synthesis=asked.synthesis,
            objective=asked.objective,
            tell=clock.told,
        )
        law, candidate = found.law, found.candidate
    with clock("exact proof"):
        document = loop_document(turbine, law, candidate, asked, files=files)
        checked = check_document(document)
    low, high, regional = models
    return TurbineDesign(
        turbine,
        asked,
        law,
        low,
        high,
        regional,
        effort,
        observer,
        candidate,
        document,
        checked,
        dict(clock.seconds),
        found,
    )
