"""Contents of a turbine's gain file that do not follow from model and law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.certificates.controller.plant_members import statement
from takagi.certificates.design.claim_summary import claim_summary
from takagi.certificates.design.turbine.result import speed_filter
from takagi.models.laws.protocol import law_words

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import ObserverDesign, TurbineDesign
    from takagi.certificates.design.turbine.settings import DesignSettings


def turbine_members(design: TurbineDesign) -> dict[str, Any]:
    """Return the certificate's member ``controller`` for a turbine's design."""
    turbine = design.turbine
    found: dict[str, Any] = {
        "name": f"{turbine.name}, {law_words(design.law.name)}",
        "turbine": turbine.name,
        "states": list(design.law.state_names),
        "trim": _trim(design),
        **observer_members(design.observer, design.settings),
        "certificate": _certificate(design),
    }
    if design.effort_sharing_law is None:
        found["start"] = _start(design)
    return found


def observer_members(observer: ObserverDesign, settings: DesignSettings) -> dict[str, Any]:
    """Return the members ``observer`` and, where the speed is filtered, ``measurement``."""
    found: dict[str, Any] = {
        "observer": {
            "l1": float(observer.gains[0]),
            "l2": float(observer.gains[1]),
            "decay_rate": float(observer.decay_rate),
            "wind_limits": [float(value) for value in observer.observer.limits],
        }
    }
    if (filters := speed_filter(settings)) is not None:
        found["measurement"] = {"speed_filter": float(filters.corner)}
        if filters.stop:
            stop = {"frequency": float(filters.stop), "passed": float(filters.passed)}
            found["measurement"]["torsion_filter"] = stop
    return found


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
