"""The claim about the coherent loop: enclose it, find one P for all cells, state the class.

Nothing is proved here.  The result is a candidate claim; ``takagi.certificates.checker`` decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.wind_class import RESERVE, WindClass, asked_rates, calmer, cell_class
from takagi.lmi.analysis.decay_rate import max_decay_rate
from takagi.lmi.analysis.invariant_ellipsoid import Ellipsoid, decay_rates, invariant_ellipsoid
from takagi.models.embedding.coherent import CellLoop
from takagi.models.embedding.loop_cell import LoopBox, LoopCell, Uncertainty
from takagi.models.embedding.vertices import LoopVertices, loop_vertices
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError
from takagi.models.law.coherent import CoherentLaw
from takagi.models.turbine.data import Turbine

__all__ = [
    "DEFAULT_BOX",
    "DEFAULT_UNCERTAINTY",
    "CoherentCandidate",
    "WindClass",
    "coherent_candidate",
    "coherent_claim",
]

Floats = NDArray[np.float64]
Tell = Callable[[str], None]

DEFAULT_BOX = LoopBox(
    speed_error=Fraction("0.04"),
    effort_lag=Fraction("0.008"),
    speed_signal=Fraction("0.03"),
    wind_share=Fraction("0.03"),
)
DEFAULT_UNCERTAINTY = Uncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)
SHRINK = 1 + 1e-5
# All rates are lowered by this factor, so often, where no quadratic function bears them.
CALMER, ATTEMPTS = 0.5, 6


@dataclass(frozen=True, slots=True, eq=False)
class CoherentCandidate:
    """Everything a claim states, in floating point but for the enclosures.

    Attributes
    ----------
    cells : the enclosed loops.
    P : (3, 3) in (e, zeta, x), or None where no common P was found.
    multipliers, wind_error, wind_rate, decay_rate : one per cell; a cell that is not believed to
        hold has wind class and decay 0.
    common_rate : the largest decay rate of one quadratic function over all cells [1/s], and
        settling_P : (3, 3) that function; both for constant wind.
    diagnosis : why there is no P, in words.
    words : the solver's.
    """

    box: LoopBox
    uncertainty: Uncertainty
    cells: tuple[LoopCell, ...]
    P: Floats | None
    multipliers: Floats
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    settling_P: Floats
    common_rate: float
    diagnosis: str
    words: str


def coherent_candidate(
    turbine: Turbine,
    law: CoherentLaw,
    *,
    box: LoopBox = DEFAULT_BOX,
    uncertainty: Uncertainty = DEFAULT_UNCERTAINTY,
    wind_class: WindClass | None = None,
    tell: Tell | None = None,
) -> CoherentCandidate:
    """Return the candidate certificate of the coherent loop: one P for all winds and corners.

    Parameters
    ----------
    box : the region around the trim that is enclosed.
    wind_class : wind rates asked for, and proportions of wind errors; the default follows what
        torque and pitch can do at each wind.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : the box asks for what tables or actuators do not have; names the wind cell.
    """
    say = tell or _silent
    shape = wind_class or WindClass()
    say("enclosing the closed loop")
    loops = [CellLoop(turbine, law, box, uncertainty, k) for k in range(len(law.schedule.wind) - 1)]
    rates = asked_rates(loops, box, shape)
    middle = np.array([float(loop.law.wind.centre) for loop in loops])
    error = np.interp(middle, shape.wind, shape.error)
    say("one quadratic function for all winds")
    for attempt in range(ATTEMPTS):
        cells = tuple(loop.enclosed(rate) for loop, rate in zip(loops, rates, strict=True))
        found = _common(cells, law, box, error)
        if found.P is not None:
            break
        last = attempt >= ATTEMPTS - 2
        rates = [Fraction(0) if last else calmer(rate, CALMER) for rate in rates]
    none = np.zeros(len(cells))
    empty = CoherentCandidate(
        box,
        uncertainty,
        cells,
        None,
        none,
        none,
        none,
        none,
        np.eye(3),
        0.0,
        found.diagnosis,
        found.words,
    )
    if found.P is None:
        return empty
    P = np.round(found.P * SHRINK, 4)
    borne = [cell_class(P, *each) for each in zip(loops, rates, error, strict=True)]
    corners = [loop_vertices(each.cell) for each in borne]
    say("the largest common decay rate")
    settling, common = _settling(P, corners)
    decay = [max(float(decay_rates(P, v.at_rest).min()), 0.0) for v in corners]
    return replace(
        empty,
        cells=tuple(each.cell for each in borne),
        P=P,
        settling_P=settling,
        common_rate=common,
        multipliers=np.array([round(each.multiplier, 7) for each in borne]),
        wind_error=np.array([each.wind_error for each in borne]),
        wind_rate=np.array([float(each.cell.wind_rate) for each in borne]),
        decay_rate=_down(RESERVE * np.array(decay)),
    )


def _common(
    cells: tuple[LoopCell, ...], law: CoherentLaw, box: LoopBox, error: Floats
) -> Ellipsoid:
    """Return one invariant ellipsoid for all cells, each at its own wind rate."""
    corners = [loop_vertices(cell) for cell in cells]
    sizes = [len(v.A) for v in corners]
    d = [v.fixed + each * v.per_wind_error for v, each in zip(corners, error, strict=True)]
    return invariant_ellipsoid(
        np.concatenate([v.A for v in corners]),
        np.concatenate(d),
        np.repeat(np.arange(len(cells)), sizes),
        _directions(box),
        speed=np.repeat(law.gains.integral_rate, sizes),
    )


def _settling(P: Floats, corners: list[LoopVertices]) -> tuple[Floats, float]:
    """Return the quadratic function with the largest decay rate over all corners, and the rate.

    The largest rate is a generalised eigenvalue problem; where it fails, P itself serves.
    """
    A = np.concatenate([v.at_rest for v in corners])
    answer = max_decay_rate(A)
    candidate = P if answer.P is None else np.asarray(answer.P)
    rounded = np.round(candidate * (1e3 / np.linalg.eigvalsh(candidate)[0]), 3)
    rate = RESERVE * float(decay_rates(rounded, A).min())
    return rounded, max(math.floor(rate * 1e6) / 1e6, 0.0)


def _directions(box: LoopBox) -> Floats:
    e, z, y = (float(b) for b in (box.speed_error, box.effort_lag, box.speed_signal))
    return np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]])


def _down(values: Floats) -> Floats:
    return np.asarray(np.floor(values * 1e5) / 1e5, dtype=np.float64)


def coherent_claim(candidate: CoherentCandidate) -> dict[str, Any]:
    """Return the claim as plain data; numbers are decimals, written as they are proved.

    Raises
    ------
    ModelError : the candidate has no P.
    """
    if candidate.P is None:
        raise ModelError(f"there is no candidate to state: {candidate.diagnosis}")
    box, cells = candidate.box, candidate.cells
    wake = "frozen wake included" if candidate.uncertainty.frozen_wake else "equilibrium wake"
    inertia = candidate.uncertainty.inertia
    low, high = float(cells[0].wind.lower), float(cells[-1].wind.upper)
    return {
        "name": f"coherent loop, {low:g} to {high:g} m/s, {wake}",
        "kind": "coherent-loop",
        "state": ["speed error [rad/s]", "effort lag [rad/s^2]", "speed integral [rad/s]"],
        "uncertainty": {
            "inertia": [float(inertia.lower), float(inertia.upper)],
            "frozen_wake": candidate.uncertainty.frozen_wake,
        },
        "box": {
            "speed_error": float(box.speed_error),
            "effort_lag": float(box.effort_lag),
            "speed_signal": float(box.speed_signal),
            "wind_share": float(box.wind_share),
        },
        "P": candidate.P.tolist(),
        "peaks": _peaks(candidate.P),
        "settling": {
            "P": candidate.settling_P.tolist(),
            "decay_rate": candidate.common_rate,
        },
        "cells": [_cell(candidate, k) for k in range(len(cells))],
    }


def _peaks(P: Floats) -> dict[str, float]:
    """Return max |h x| over x'Px <= 1 = sqrt(h P^-1 h'), rounded up."""
    inverse = np.linalg.inv(P)
    rows = {
        "speed_error": np.array([1, 0, 0]),
        "effort_lag": np.array([0, 1, 0]),
        "speed_signal": np.array([1, 0, -1]),
        "integral": np.array([0, 0, 1]),
    }
    return {
        name: math.ceil(float(np.sqrt(h @ inverse @ h)) * (1 + 1e-6) * 1e7) / 1e7
        for name, h in rows.items()
    }


def _cell(candidate: CoherentCandidate, k: int) -> dict[str, Any]:
    cell = candidate.cells[k]
    ranges = ("wind", "stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
    sizes = (
        "residual",
        "wind_gain",
        "inertia_gain",
        "effectiveness_slope",
        "reference_slope",
        "lag_disturbance",
    )
    stated: dict[str, Any] = {}
    for name in ranges:
        interval: Interval = getattr(cell, name)
        stated[name] = [float(interval.lower), float(interval.upper)]
    for name in sizes:
        stated[name] = float(getattr(cell, name))
    return stated | {
        "integral_rate": float(cell.integral_rate.lower),
        "multiplier": float(candidate.multipliers[k]),
        "wind_error": float(candidate.wind_error[k]),
        "wind_rate": float(candidate.wind_rate[k]),
        "decay_rate": float(candidate.decay_rate[k]),
    }


def _silent(_: str) -> None:
    """Say nothing."""
