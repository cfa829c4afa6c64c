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
from takagi.certificates.controller.longest_sample import longest_of_turbine
from takagi.certificates.controller.plant_members import statement
from takagi.certificates.design.design import StepClock, Tell
from takagi.certificates.design.turbine.effort_sharing_gains import (
    EffortSharingGainDesign,
    effort_sharing_gain_design,
    wind_by_wind_law,
    wind_observer_design,
)
from takagi.certificates.design.turbine.published_law import regional_design
from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary, speed_filter
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.models.laws.protocol import law_words
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.effort_sharing_gains import ObserverDesign
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
    chosen = settings or default_settings(turbine)
    setpoint = chosen.speed_setpoint
    turbine = derated(turbine, chosen.torque_setpoint, speed_setpoint=setpoint)
    clock = StepClock(tell)
    low, high, regional = regional_design(turbine, speed_setpoint=setpoint, clock=clock)
    with clock("wind observer"):
        observer = wind_observer_design(turbine, chosen)
    effort = gain_design = None
    law: Law
    make_document: Callable[[], dict[str, Any]]
    if chosen.law == "coherent":
        effort, gain_design = _effort_sharing(turbine, chosen, clock)
        law = gain_design.law
        make_document = partial(
            loop_document,
            turbine,
            law,
            gain_design.candidate,
            chosen,
            files=files,
            controller=observer_members(observer, chosen),
            tell=clock.told,
        )
    else:
        from takagi.certificates.design.turbine.published_law import claimed_law

        law, make_document = claimed_law(turbine, chosen, (low, high, regional), files, clock)
    with clock("exact proof"):
        document = make_document()
        checked = check_document(document)
    design = TurbineDesign(
        turbine=turbine,
        settings=chosen,
        law=law,
        partial_load=low,
        full_load=high,
        regional=regional,
        effort=effort,
        observer=observer,
        candidate=None if gain_design is None else gain_design.candidate,
        document=document,
        checked=checked,
        seconds=dict(clock.seconds),
        synthesis=gain_design,
    )
    return replace(design, document=bound(document, turbine_members(design)))


def _effort_sharing(
    turbine: Turbine, settings: DesignSettings, clock: StepClock
) -> tuple[EffortDesign, EffortSharingGainDesign]:
    with clock("gains of the effort-sharing law"):
        effort, law = wind_by_wind_law(turbine, settings)
    with clock("joint analysis of the blended loop"):
        return effort, effort_sharing_gain_design(
            turbine,
            law,
            box=settings.box,
            uncertainty=settings.uncertainty,
            synthesis=settings.synthesis,
            objective=settings.objective,
            remade=lambda other_turbine: wind_by_wind_law(other_turbine, settings)[1],
            tell=clock.told,
        )


def turbine_members(design: TurbineDesign) -> dict[str, Any]:
    """Return the certificate's member ``controller`` for a turbine's design."""
    turbine = design.turbine
    members: dict[str, Any] = {
        "name": f"{turbine.name}, {law_words(design.law.name)}",
        "turbine": turbine.name,
        "states": list(design.law.state_names),
        "trim": _trim(design),
        **observer_members(design.observer, design.settings),
        "certificate": _certificate(design),
    }
    programs = ["observer", *(["speed filter"] if "measurement" in members else [])]
    law = {"name": design.law.name}
    if (longest := longest_of_turbine({**members, "law": law}, programs)) is not None:
        members["sampling"] = longest.member
    if design.effort_sharing_law is None:
        members["start"] = _start(design)
    return members


def observer_members(observer: ObserverDesign, settings: DesignSettings) -> dict[str, Any]:
    """Return the members ``observer`` and, where the speed is filtered, ``measurement``."""
    members: dict[str, Any] = {
        "observer": {
            "l1": float(observer.gains[0]),
            "l2": float(observer.gains[1]),
            "decay_rate": float(observer.decay_rate),
            "wind_limits": [float(value) for value in observer.observer.limits],
        }
    }
    if (filters := speed_filter(settings)) is not None:
        members["measurement"] = {"speed_filter": float(filters.corner)}
        if filters.stop:
            stop = {"frequency": float(filters.stop), "passed": float(filters.passed)}
            members["measurement"]["torsion_filter"] = stop
    return members


def _trim(design: TurbineDesign) -> dict[str, Any]:
    from takagi.models.turbine.trim import trim

    setpoint = design.settings.speed_setpoint
    points = [trim(design.turbine, v, speed_setpoint=setpoint) for v in _winds(design)]
    return {
        "wind": [float(p.wind) for p in points],
        "rotor_speed": [round(float(p.rotor_speed), 9) for p in points],
        "pitch": [round(float(p.pitch), 9) for p in points],
        "torque": [round(float(p.torque), 6) for p in points],
        "region": [p.region for p in points],
    }


def _winds(design: TurbineDesign) -> list[float]:
    from takagi.models.turbine.trim import rated_wind

    turbine = design.turbine
    steps = int(round((turbine.cut_out - turbine.cut_in) / 0.5))
    winds = {turbine.cut_in + 0.5 * k for k in range(steps)} | {turbine.cut_out}
    winds.add(round(rated_wind(turbine, speed_setpoint=design.settings.speed_setpoint), 4))
    return sorted(winds)


def _start(design: TurbineDesign) -> dict[str, Any]:
    """Return the initial values of a published law's integrals, over wind."""
    winds = _winds(design)
    states = [design.law.initial_state(v).tolist() for v in winds]
    columns = zip(*states, strict=True)
    return {
        "wind": [float(v) for v in winds],
        "integrals": [[round(float(x), 9) for x in column] for column in columns],
    }


def _certificate(design: TurbineDesign) -> dict[str, Any]:
    summary = claim_summary(design)
    return {
        **statement(design.checked),
        "decay_rate": None if summary is None else summary.decay_rate,
        "overspeed": None if summary is None else summary.overspeed,
        "wind_class": None
        if summary is None
        else {
            "cells": [list(cell) for cell in summary.winds],
            "proved": list(summary.proved),
            "wind_error": list(summary.wind_error),
            "wind_rate": list(summary.wind_rate),
            "decay_rate": list(summary.decay_rates),
        },
    }
