"""One point of the effort-sharing law's sweep: what is proved for some settings and uncertainties.

At each point the gains are designed wind by wind, one quadratic function is sought for all winds,
and its claim is judged by the independent checker on the decimals that a certificate would state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    effort_sharing_claim,
    failing_winds,
)
from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate, WindClass
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.certificates.sweep.axis import AxisKind
from takagi.lmi.turbine.effort import EffortSettings, effort_gains
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

AXES = (
    AxisKind("overlap", "rad/s^2"),
    AxisKind("bandwidth", "1/s"),
    AxisKind("partial-bandwidth", "1/s"),
    AxisKind("effectiveness", "-"),
    AxisKind("pitch-lag", "s"),
    AxisKind("inertia", "-", highest=0.9, closed=True),
    AxisKind("frozen-wake", "-", highest=3.0, closed=True),
    AxisKind("power-coefficient", "-", highest=0.9, closed=True),
    AxisKind("wind-rate", "m/s^2", closed=True),
    AxisKind("speed-error", "rad/s"),
    AxisKind("wind-share", "-", highest=0.5),
)
REMEDY = (
    "reduce the uncertainty (inertia, frozen-wake, power-coefficient), the box (speed-error) or "
    "the bandwidth"
)
# The transition between partial and full load, as fractions of rated wind: 10 to 13 m/s for the
# NREL 5-MW turbine.
TRANSITION = (0.875, 1.135)


def point(turbine: Turbine, at: Mapping[str, float]) -> dict[str, Any]:
    """Return what is proved at a point; wind class, overspeed and decay only where PROVED.

    Parameters
    ----------
    at : axis name -> value; a name that is missing keeps the setting of a design.

    Raises
    ------
    ModelError : no trim, no gain, or a box that leaves a table or an actuator's limits; names the
        wind and what to change.
    """
    plant, law, covered = loop_at(turbine, at)
    candidate = effort_sharing_candidate(plant, law, **covered)
    if candidate.P is None:
        reason = f"{failing_winds(candidate.cells)}; {REMEDY}"
        return {"verdict": "UNDECIDED", "reason": reason}
    document = certificate_document(
        model=turbine_data(plant, []),
        gains=effort_sharing_law_data(law),
        claims=[effort_sharing_claim(candidate)],
        provenance={},
    )
    claim = check_document(document).claims[0]
    if claim.verdict is not Verdict.PROVED:
        return {"verdict": claim.verdict.name, "reason": f"{claim.text}; {REMEDY}"}
    proved = {"verdict": "PROVED", "reason": None, **_guaranteed(plant, law, candidate)}
    for low, high in wind_ranges(turbine):
        proved |= _over_range(candidate, low, high)
    return proved


def loop_at(
    turbine: Turbine, at: Mapping[str, float]
) -> tuple[Turbine, EffortSharingLaw, dict[str, Any]]:
    """Return plant, law with gains found wind by wind, and what its claim shall cover.

    Box, uncertainty and wind class are those of a design, except for what the axes change.
    """
    asked = default_settings(turbine)
    plant = replace(turbine, pitch_time_constant=at.get("pitch-lag", turbine.pitch_time_constant))
    box, uncertainty = _box(asked.box, at), _uncertainty(asked.uncertainty, at)
    changed: dict[str, Any] = {}
    if "speed-error" in at:
        changed["speed_error"] = float(box.speed_signal)
    for name in ("bandwidth", "partial-bandwidth"):
        if name in at:
            changed[name.replace("-", "_")] = at[name]
    if "inertia" in at:
        span = uncertainty.inertia
        changed["inertia"] = (float(span.lower), float(span.upper))
    schedule = effort_schedule(
        plant,
        overlap=at.get("overlap", asked.overlap),
        effectiveness_share=at.get("effectiveness", asked.effectiveness_share),
        speed_setpoint=asked.speed_setpoint,
    )
    if "frozen-wake" in at:
        limit = np.round(at["frozen-wake"] * schedule.effectiveness_limit, 6)
        schedule = replace(schedule, effectiveness_limit=limit)
    wind_class = WindClass()
    if "wind-rate" in at:
        factor = at["wind-rate"] / max(wind_class.rate)
        wind_class = replace(wind_class, rate=tuple(factor * rate for rate in wind_class.rate))
    effort = replace(asked.effort or EffortSettings(), **changed)
    law = EffortSharingLaw.of(plant, schedule, effort_gains(plant, schedule, effort).gains)
    return plant, law, {"box": box, "uncertainty": uncertainty, "wind_class": wind_class}


def wind_ranges(turbine: Turbine) -> tuple[tuple[float, float], ...]:
    """Return all winds, then partial load, transition and full load [m/s]."""
    low, high = (float(round(share * rated_wind(turbine))) for share in TRANSITION)
    parts = ((turbine.cut_in, low), (low, high), (high, turbine.cut_out))
    return ((turbine.cut_in, turbine.cut_out), *parts)


def _box(box: LoopBox, at: Mapping[str, float]) -> LoopBox:
    if "speed-error" in at:
        wanted = _decimal(at["speed-error"])
        share = wanted / box.speed_error
        box = replace(
            box,
            speed_error=wanted,
            effort_lag=_rounded_down(box.effort_lag * share),
            speed_signal=_rounded_down(box.speed_signal * share),
        )
    if "wind-share" in at:
        box = replace(box, wind_share=_decimal(at["wind-share"]))
    return box


def _uncertainty(uncertainty: LoopUncertainty, at: Mapping[str, float]) -> LoopUncertainty:
    for axis, name in (("inertia", "inertia"), ("power-coefficient", "power_coefficient")):
        if axis in at:
            share = _decimal(at[axis])
            uncertainty = replace(uncertainty, **{name: Interval(1 - share, 1 + share)})
    if "frozen-wake" in at:
        uncertainty = replace(uncertainty, frozen_wake=at["frozen-wake"] > 0)
    return uncertainty


def _decimal(value: float) -> Fraction:
    """Return the number as it is written: a certificate states decimals."""
    return Fraction(f"{value:.9g}")


def _rounded_down(value: Fraction) -> Fraction:
    """Return four digits of a number."""
    return _decimal(float(f"{float(value) * (1 - 1e-12):.4g}"))


def _guaranteed(
    turbine: Turbine, law: EffortSharingLaw, candidate: EffortSharingCandidate
) -> dict[str, Any]:
    """Return overspeed bound, rounded up, and common decay rate, as the claim states them."""
    peak = float(effort_sharing_claim(candidate)["peaks"]["speed_error"])
    most = float(law.schedule.rotor_speed.max()) + peak
    excess = 100 * (most / turbine.rated_rotor_speed - 1)
    return {
        "overspeed [%]": float(np.ceil(1e4 * excess) / 1e4),
        "common_decay [1/s]": float(candidate.common_rate),
    }


def _over_range(candidate: EffortSharingCandidate, low: float, high: float) -> dict[str, Any]:
    """Return wind class and decay rate over the cells that meet a range of winds [m/s]."""
    lower = np.array([float(cell.wind.lower) for cell in candidate.cells])
    upper = np.array([float(cell.wind.upper) for cell in candidate.cells])
    inside = (upper > low) & (lower < high)
    width = (upper - lower)[inside]
    error, rate = candidate.wind_error[inside], candidate.wind_rate[inside]
    found = {
        "mean_wind_error [m/s]": _short(float(width @ error / width.sum())),
        "least_wind_error [m/s]": float(error.min()),
        "mean_wind_rate [m/s^2]": _short(float(width @ rate / width.sum())),
        "least_wind_rate [m/s^2]": float(rate.min()),
        "least_decay [1/s]": float(candidate.decay_rate[inside].min()),
    }
    return {f"{low:g} to {high:g} m/s: {key}": value for key, value in found.items()}


def _short(value: float) -> float:
    return float(f"{value:.6g}")
