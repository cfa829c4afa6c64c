r"""The gain file ``gains.json``: everything a controller needs, and what is proved about it.

``law`` is, number by number, the object inside the certificate, so that
``takagi check certificate.json --gains gains.json`` compares equal.  What is proved is about these
decimals.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from takagi.reports.gain_file_schema import FORMAT, VERSION, GainFile, gain_file_schema

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import TurbineDesign
    from takagi.lmi.turbine.regional import RegionGains
    from takagi.models.law.coherent import CoherentLaw
    from takagi.models.premise import Premise

__all__ = ["dump_gains", "gain_file", "gain_file_schema"]

RAMP = [
    "psi(s) = 0 for s <= -overlap",
    "psi(s) = (s + overlap)^2 / (4 overlap) for |s| <= overlap",
    "psi(s) = s for s >= overlap",
]
COHERENT_UNITS = {
    "wind": "m/s",
    "rotor_speed": "rad/s",
    "trim_effort": "rad/s^2",
    "effectiveness": "rad/s^2 per rad",
    "effectiveness_limit": "rad/s^2 per rad",
    "overlap": "rad/s^2",
    "proportional": "1/s",
    "integral_rate": "1/s",
    "inertia_feedforward": "rad/s per m/s",
    "feedforward_limit": "rad/s^2",
    "pitch_lead": "s",
    "rated_torque": "N m, high-speed shaft",
    "effort_torque": "N m s^2/rad",
    "pitch_min": "rad",
    "pitch_max": "rad",
    "wind_filter": "s",
    "integral_limit": "rad/s",
}
COMMON_UNITS = {
    "ramp.overlap": "rad/s^2",
    "trim.wind": "m/s",
    "trim.rotor_speed": "rad/s",
    "trim.pitch": "rad",
    "trim.torque": "N m, high-speed shaft",
    "trim.region": "-",
    "limits.torque": "N m, high-speed shaft",
    "limits.torque_rate": "N m/s, high-speed shaft",
    "limits.pitch": "rad",
    "limits.pitch_rate": "rad/s",
    "observer.l1": "1/s",
    "observer.l2": "m/s^2 per rad/s",
    "observer.decay_rate": "1/s",
    "observer.wind_limits": "m/s",
    "filter.f1": "-",
    "filter.f2": "-",
    "regional.partial load.k_x": "N m per rad/s",
    "regional.partial load.k_I": "N m per rad",
    "regional.full load.k_x": "rad per rad/s, rad per rad",
    "regional.full load.k_I": "rad per rad",
    "certificate.decay_rate": "1/s",
    "certificate.overspeed": "-",
    "certificate.wind_class.cells": "m/s",
    "certificate.wind_class.wind_error": "m/s",
    "certificate.wind_class.wind_rate": "m/s^2",
    "certificate.wind_class.decay_rate": "1/s",
}


def gain_file(design: TurbineDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, checked against its schema.

    ``law`` is ``design.document["gains"]`` itself; every other number is written as it is used.

    Raises
    ------
    pydantic.ValidationError : a law whose tables do not fit each other.
    """
    turbine, law = design.turbine, design.document["gains"]
    found: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "name": f"{turbine.name}, {design.law.name} law",
        "turbine": turbine.name,
        "units": _units(design),
        "law": law,
        "states": list(design.law.state_names),
        "schedule": _schedule(design),
        "execution": _execution(design),
        "ramp": None if design.coherent is None else _ramp(design.coherent),
        "filter": _filter(design),
        "trim": _trim(design),
        "limits": {
            "torque": [0.0, turbine.rated_torque],
            "torque_rate": turbine.torque_rate_limit,
            "pitch": [turbine.pitch_min, turbine.pitch_max],
            "pitch_rate": turbine.pitch_rate_limit,
        },
        "observer": _observer(design),
        "regional": [_region(part) for part in (design.regional.partial, design.regional.full)],
        "certificate": _certificate(design),
    }
    GainFile.model_validate(found)
    return found


def dump_gains(content: dict[str, Any]) -> str:
    """Return the file's text: one line per entry, the same bytes for the same numbers."""
    body = ",\n".join(
        f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in content.items()
    )
    return f"{{\n{body}\n}}\n"


def _units(design: TurbineDesign) -> dict[str, str]:
    if design.coherent is None:
        return COMMON_UNITS
    return {f"law.{name}": unit for name, unit in COHERENT_UNITS.items()} | COMMON_UNITS


def _schedule(design: TurbineDesign) -> dict[str, str]:
    if design.coherent is None:
        return {
            "variables": "rotor speed, pitch, wind estimate",
            "interpolation": "memberships h_i of the regional rules; held at the nearer bound",
        }
    return {
        "variables": "schedule wind v_s = low-passed wind estimate, v_s' = (v_hat - v_s) / tau_f",
        "interpolation": "linear between nodes; integral_rate, inertia_feedforward and "
        "feedforward_limit constant between two nodes",
        "feedforward": "torque gives up effort_torque (f v_s' held within +-g) more, and stays "
        "within 0 and rated; pitch leads by pitch_lead v_s' d/dv_s [psi(U) / b] at fixed e - x, "
        "and stays at or above pitch_min",
        "outside": "the wind is held at the first or last node",
    }


def _execution(design: TurbineDesign) -> dict[str, str]:
    """Return what one sample does; ``takagi.models.law.sampled`` runs it."""
    often = {
        "every": "T = 0.01 to 0.02 s; what is sent holds until the next sample",
        "rates": "limits.torque_rate and limits.pitch_rate are the actuators'; what is sent may be "
        "held to them",
    }
    if design.coherent is None:
        return often | {"integrals": "x + T x', held nowhere"}
    return often | {
        "schedule wind": "v_s after = v_hat + (v_s - v_hat) exp(-T / wind_filter), v_hat held "
        "within the table's winds",
        "its rate": "v_s' = (v_s after - v_s) / T, in the feed-forward of this sample",
        "integral": "x after = x - T integral_rate e, held within +-integral_limit",
    }


def _ramp(law: CoherentLaw) -> dict[str, Any]:
    return {"overlap": float(law.schedule.overlap), "formula": RAMP}


def _filter(design: TurbineDesign) -> dict[str, Any]:
    if design.coherent is not None:
        return {
            "kind": "effort sharing: f1 = psi'(U), f2 = 1 - psi'(U)",
            "f1": [0.0, 1.0],
            "f2": [0.0, 1.0],
            "corners": [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]],
            "premises": ["U, demanded effort [rad/s^2]"],
            "parameters": {"overlap [rad/s^2]": float(design.coherent.schedule.overlap)},
        }
    coupling = design.law.coupling  # type: ignore[attr-defined]
    ramp = coupling.speed_ramp
    return {
        "kind": f"coupling filter, {coupling.variant}",
        "f1": [0.0, 1.0],
        "f2": [float(value) for value in coupling.torque_corners],
        "corners": coupling.corners.tolist(),
        "premises": ["omega, rotor speed [rad/s]", "T_g, commanded torque [N m]"],
        "parameters": {
            "speed ramp start [rad/s]": float(ramp.start),
            "speed overlap [rad/s]": float(ramp.width),
            "speed ramp shape": ramp.shape,
            "torque overlap [N m]": float(coupling.torque_overlap),
            "minimum torque [N m]": float(coupling.minimum_torque),
            "rated torque [N m]": float(coupling.rated_torque),
            "largest command [N m]": float(coupling.top_torque),
        },
    }


def _trim(design: TurbineDesign) -> dict[str, Any]:
    from takagi.models.turbine.trim import rated_wind, trim

    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    steps = int(round((turbine.cut_out - turbine.cut_in) / 0.5))
    winds = {turbine.cut_in + 0.5 * k for k in range(steps)} | {turbine.cut_out}
    winds.add(round(rated_wind(turbine, speed_setpoint=setpoint), 4))
    points = [trim(turbine, wind, speed_setpoint=setpoint) for wind in sorted(winds)]
    return {
        "wind": [float(p.wind) for p in points],
        "rotor_speed": [round(float(p.rotor_speed), 9) for p in points],
        "pitch": [round(float(p.pitch), 9) for p in points],
        "torque": [round(float(p.torque), 6) for p in points],
        "region": [p.region for p in points],
    }


def _observer(design: TurbineDesign) -> dict[str, Any]:
    found = design.observer
    return {
        "l1": float(found.gains[0]),
        "l2": float(found.gains[1]),
        "decay_rate": float(found.decay_rate),
        "wind_limits": [float(value) for value in found.observer.limits],
        "premise": _premise(found.model.premises[0]),
        "equations": [
            "omegahat' = (T_r(omega, beta, vhat) - n_g T) / J + l1 (omega - omegahat)",
            "vhat' = l2 (omega - omegahat)",
        ],
    }


def _premise(premise: Premise) -> dict[str, Any]:
    return {
        "name": premise.name,
        "unit": premise.unit,
        "lower": float(premise.lower),
        "upper": float(premise.upper),
        "evidence": premise.evidence,
    }


def _region(part: RegionGains) -> dict[str, Any]:
    model = part.model
    return {
        "region": part.region,
        "status": str(part.status),
        "states": list(model.states),
        "input": model.inputs[0],
        "box": {name: [float(low), float(high)] for name, (low, high) in model.box.items()},
        "premises": [_premise(premise) for premise in model.premises],
        "memberships": "h_i = product over premises of (upper - z)/(upper - lower) at corner 0, "
        "(z - lower)/(upper - lower) at corner 1",
        "rules": [list(rule) for rule in model.rules],
        "k_x": None if part.k_x is None else part.k_x.tolist(),
        "k_I": None if part.k_I is None else part.k_I.tolist(),
        "decay_rate": None if part.decay_rate is None else float(part.decay_rate),
        "bounds": {name: [float(v) for v in pair] for name, pair in part.bounds.items()},
    }


def _certificate(design: TurbineDesign) -> dict[str, Any]:
    from takagi.reports.claim_summary import claim_summary

    summary = claim_summary(design)
    return {
        "verdict": design.checked.verdict.name,
        "claims": [
            {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
            for claim in design.checked.claims
        ],
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
        "sha256": dict(design.document["provenance"]["sha256"]),
    }
