"""From a turbine to a checked design: regional models, gains, law, observer, certificate.

The one place where the floors below meet: everything that leaves the house (gain file, report,
appendix, simulation) reads the ``TurbineDesign`` made here.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.certificate import check_document
from takagi.certificates.checker.result import Checked
from takagi.certificates.coherent import (
    DEFAULT_BOX,
    DEFAULT_UNCERTAINTY,
    CoherentCandidate,
    coherent_candidate,
    coherent_claim,
)
from takagi.certificates.document import certificate_document, coherent_law_data, turbine_data
from takagi.certificates.failing_winds import failing_winds
from takagi.certificates.provenance import provenance
from takagi.models.embedding.coherent import LoopBox, Uncertainty
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign, EffortSettings
    from takagi.lmi.turbine.regional import RegionalGains
    from takagi.models.law.coherent import CoherentLaw
    from takagi.models.law.law import Law
    from takagi.models.ts_model import TSModel
    from takagi.models.turbine.wind_observer import WindObserver

__all__ = ["LAWS", "DesignSettings", "ObserverDesign", "TurbineDesign", "design_turbine"]

LAWS = ("coherent", "paper", "paper-two-integrators")
Tell = Callable[[str], None]

OBSERVER_DECAY = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSettings:
    """What is asked for; the defaults are those of the NREL 5-MW turbine.

    ``takagi.certificates.turbine_scale.default_settings`` carries them to another size.

    Attributes
    ----------
    law : "coherent", "paper" or "paper-two-integrators".
    overlap : eps of the effort ramp [rad/s^2] (coherent).
    speed_overlap : eps_omega of the coupling filter [rad/s] (paper laws).
    torque_overlap : eps_T of the coupling filter [N m] (paper laws).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.
    effort : what is asked of the coherent gains; None takes the defaults.
    box, uncertainty : what the coherent certificate covers.
    """

    law: str = "coherent"
    overlap: float = 0.01
    speed_overlap: float = 0.1
    torque_overlap: float = 2000.0
    speed_setpoint: float | None = None
    effort: EffortSettings | None = None
    box: LoopBox = DEFAULT_BOX
    uncertainty: Uncertainty = DEFAULT_UNCERTAINTY

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ModelError(f"law {self.law!r} was given; choose one of {', '.join(LAWS)}")
        for name in ("overlap", "speed_overlap", "torque_overlap"):
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

    @property
    def coherent(self) -> CoherentLaw | None:
        """The law where it is the coherent one, else None."""
        from takagi.models.law.coherent import CoherentLaw

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
    from takagi.certificates.turbine_scale import default_settings

    asked = settings or default_settings(turbine)
    clock = _Clock(tell)
    models = _regions(turbine, asked, clock)
    with clock("wind observer"):
        observer = _observer(turbine, asked)
    if asked.law != "coherent":
        from takagi.certificates.paper_design import paper_design

        return paper_design(turbine, asked, models, observer, files, clock)
    return _coherent(turbine, asked, models, observer, files, clock)


class _Clock:
    """Times the steps and tells of them."""

    def __init__(self, tell: Tell | None) -> None:
        self._tell = tell
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        if self._tell is not None:
            self._tell(step)
        started = time.perf_counter()
        yield
        self.seconds[step] = time.perf_counter() - started


def _regions(
    turbine: Turbine, asked: DesignSettings, clock: _Clock
) -> tuple[TSModel, TSModel, RegionalGains]:
    from takagi.certificates.turbine_scale import region_requirements
    from takagi.lmi.turbine.regional import regional_gains
    from takagi.models.turbine.full_load import full_load_model
    from takagi.models.turbine.partial_load import partial_load_model

    with clock("partial-load model"):
        low = partial_load_model(turbine, speed_setpoint=asked.speed_setpoint)
    with clock("full-load model"):
        high = full_load_model(turbine, speed_setpoint=asked.speed_setpoint)
    with clock("regional gains"):
        partial_load, full_load = region_requirements(turbine)
        gains = regional_gains(
            turbine,
            partial_load=partial_load,
            full_load=full_load,
            partial_model=low,
            full_model=high,
            speed_setpoint=asked.speed_setpoint,
        )
    return low, high, gains


def _observer(turbine: Turbine, asked: DesignSettings) -> ObserverDesign:
    from takagi.lmi.synthesis.observation import observer
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
    clock: _Clock,
) -> TurbineDesign:
    from takagi.lmi.turbine.effort import effort_gains
    from takagi.models.law.coherent import CoherentLaw
    from takagi.models.law.schedule import effort_schedule

    with clock("gains of the coherent law"):
        schedule = effort_schedule(
            turbine, overlap=asked.overlap, speed_setpoint=asked.speed_setpoint
        )
        effort = effort_gains(turbine, schedule, asked.effort)
        law = CoherentLaw.of(turbine, schedule, effort.gains)
    with clock("joint analysis of the blended loop"):
        candidate = coherent_candidate(turbine, law, box=asked.box, uncertainty=asked.uncertainty)
        if candidate.P is None:
            raise ModelError(
                "joint analysis: no common quadratic function over all winds was found; "
                f"{failing_winds(candidate.cells)}. Reduce the uncertainty or the box, or change "
                "the bandwidth"
            )
    with clock("exact proof"):
        document = certificate_document(
            model=turbine_data(turbine, files),
            gains=coherent_law_data(law),
            claims=[coherent_claim(candidate)],
            provenance=provenance(asked, {"joint analysis": candidate.words}),
        )
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
    )
