"""From a turbine to a checked design: regional models, gains, law, observer, certificate.

This module combines models, lmi and certificates for turbines. All outputs (gain file, report,
appendix, simulation) read the ``TurbineDesign`` made here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.loop_claims import loop_document
from takagi.certificates.controller.content import bound
from takagi.certificates.design.step_clock import StepClock, Tell
from takagi.certificates.design.turbine.effort_sharing_gains import (
    EffortSharingGainDesign,
    effort_sharing_gain_design,
)
from takagi.certificates.design.turbine.gain_file_members import observer_members, turbine_members
from takagi.certificates.design.turbine.regions import regional_design
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.certificates.design.turbine.wind_by_wind import wind_by_wind_law, wind_observer_design
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign
    from takagi.models.laws.protocol import Law


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
    asked = settings or default_settings(turbine)
    turbine = derated(turbine, asked.torque_setpoint, speed_setpoint=asked.speed_setpoint)
    clock = StepClock(tell)
    low, high, regional = regional_design(turbine, speed_setpoint=asked.speed_setpoint, clock=clock)
    with clock("wind observer"):
        observer = wind_observer_design(turbine, asked)
    effort = found = None
    law: Law
    stated: Callable[[], dict[str, Any]]
    if asked.law == "coherent":
        effort, found = _effort_sharing(turbine, asked, clock)
        law = found.law
        stated = partial(
            loop_document,
            turbine,
            law,
            found.candidate,
            asked,
            files=files,
            controller=observer_members(observer, asked),
            tell=clock.told,
        )
    else:
        from takagi.certificates.design.turbine.published_law import claimed_law

        law, stated = claimed_law(turbine, asked, (low, high, regional), files, clock)
    with clock("exact proof"):
        document = stated()
        checked = check_document(document)
    design = TurbineDesign(
        turbine=turbine,
        settings=asked,
        law=law,
        partial_load=low,
        full_load=high,
        regional=regional,
        effort=effort,
        observer=observer,
        candidate=None if found is None else found.candidate,
        document=document,
        checked=checked,
        seconds=dict(clock.seconds),
        synthesis=found,
    )
    return replace(design, document=bound(document, turbine_members(design)))


def _effort_sharing(
    turbine: Turbine, asked: DesignSettings, clock: StepClock
) -> tuple[EffortDesign, EffortSharingGainDesign]:
    with clock("gains of the effort-sharing law"):
        effort, law = wind_by_wind_law(turbine, asked)
    with clock("joint analysis of the blended loop"):
        return effort, effort_sharing_gain_design(
            turbine,
            law,
            box=asked.box,
            uncertainty=asked.uncertainty,
            synthesis=asked.synthesis,
            objective=asked.objective,
            tell=clock.told,
        )
