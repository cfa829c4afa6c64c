"""The result of a candidate about the loop: the checker's verdict and its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_claim
from takagi.certificates.claims.turbine.failing_winds import failing_winds
from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.certificates.sweep.grid import UNDECIDED
from takagi.certificates.sweep.wind_ranges import WindRange
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.turbine.aerodynamics import rotor_power
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

REMEDY = (
    "reduce the uncertainty (inertia, frozen-wake, power-coefficient), the box (speed-error) or "
    "the bandwidth"
)
DIGITS = 6


def checked(turbine: Turbine, law: EffortSharingLaw, candidate: EffortSharingCandidate) -> Claim:
    """Return the independent checker's verdict on the candidate's claim, as it would be written.

    Raises
    ------
    ModelError : the candidate has no P.
    """
    document = certificate_document(
        model=turbine_data(turbine, []),
        gains=effort_sharing_law_data(law),
        claims=[effort_sharing_claim(candidate)],
        provenance={},
    )
    return check_document(document).claims[0]


def answer(
    turbine: Turbine,
    law: EffortSharingLaw,
    candidate: EffortSharingCandidate,
    ranges: Sequence[WindRange],
) -> dict[str, Any]:
    """Return a point's result: verdict, reason, and guaranteed numbers, with units in the keys.

    Wind class, overspeed and decay are given only where the checker says PROVED.  ``ranges`` has
    the least values over the wind cells that meet a range; ``cells`` has the values of all cells.
    """
    common = {
        "energy_cost [%]": energy_cost(turbine, law),
        "largest_gain [1/s]": float(law.gains.proportional.max()),
    }
    if candidate.P is None:
        words = failing_winds(candidate.cells)
        return {"verdict": UNDECIDED, "reason": f"{words}; {REMEDY}", **common}
    claim = checked(turbine, law, candidate)
    if claim.verdict is not Verdict.PROVED:
        return {"verdict": claim.verdict.name, "reason": f"{claim.text}; {REMEDY}", **common}
    return {
        "verdict": claim.verdict.name,
        "reason": None,
        **common,
        **_guaranteed(turbine, law, candidate),
        "ranges": [range_class(candidate, each) for each in ranges],
        "cells": _cells(candidate),
    }


def energy_cost(turbine: Turbine, law: EffortSharingLaw) -> float:
    """Return the power that the overlap loses at rated wind [% of rated power], at the law's trim.

    The rotor could give rated power there. The ramp divides the effort, so that pitch reduces the
    power and the torque is below its rated value.
    """
    wind = rated_wind(turbine)
    table = law.schedule
    speed = float(np.interp(wind, table.wind, table.rotor_speed))
    effort = float(np.interp(wind, table.wind, table.trim_effort))
    torque = table.torque(wind, turbine)
    available = float(rotor_power(turbine, speed, turbine.pitch_min, wind))
    if effort >= table.overlap:
        return 0.0
    return _short(100 * (1 - turbine.gear_ratio * torque * speed / available))


def range_class(candidate: EffortSharingCandidate, winds: WindRange) -> dict[str, Any]:
    """Return the least wind class and decay rate over the cells that meet a range of winds."""
    low = np.array([float(cell.wind.lower) for cell in candidate.cells])
    high = np.array([float(cell.wind.upper) for cell in candidate.cells])
    inside = (high > winds.low) & (low < winds.high)
    if not inside.any():
        return {"name": winds.name, "winds [m/s]": [winds.low, winds.high]}
    share = (high - low)[inside]
    return {
        "name": winds.name,
        "winds [m/s]": [winds.low, winds.high],
        "least_wind_error [m/s]": float(candidate.wind_error[inside].min()),
        "mean_wind_error [m/s]": _short(float(share @ candidate.wind_error[inside] / share.sum())),
        "least_wind_rate [m/s^2]": float(candidate.wind_rate[inside].min()),
        "mean_wind_rate [m/s^2]": _short(float(share @ candidate.wind_rate[inside] / share.sum())),
        "least_decay [1/s]": float(candidate.decay_rate[inside].min()),
    }


def _guaranteed(
    turbine: Turbine, law: EffortSharingLaw, candidate: EffortSharingCandidate
) -> dict[str, Any]:
    """Return overspeed, common decay and pitch rate; the claim's decimals, rounded outward."""
    peaks = effort_sharing_claim(candidate)["peaks"]
    most = float(law.schedule.rotor_speed.max()) + peaks["speed_error"]
    asked = max(float(cell.pitch_rate) for cell in candidate.cells)
    least = min(float(cell.lag_rate.lower) for cell in candidate.cells)
    return {
        "overspeed [%]": float(np.ceil(1e4 * (100 * (most / turbine.rated_rotor_speed - 1))) / 1e4),
        "speed_error [rad/s]": float(peaks["speed_error"]),
        "common_decay [1/s]": float(candidate.common_rate),
        "pitch_rate_asked [deg/s]": _short(float(np.rad2deg(asked))),
        "pitch_rate_passed [-]": _short(least * turbine.pitch_time_constant),
    }


def _cells(candidate: EffortSharingCandidate) -> dict[str, Any]:
    edges = [float(cell.wind.lower) for cell in candidate.cells]
    edges.append(float(candidate.cells[-1].wind.upper))
    return {
        "wind [m/s]": edges,
        "wind_error [m/s]": candidate.wind_error.tolist(),
        "wind_rate [m/s^2]": candidate.wind_rate.tolist(),
        "decay [1/s]": candidate.decay_rate.tolist(),
    }


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
