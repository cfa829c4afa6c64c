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

from takagi.lmi.analysis.decay_rate import max_decay_rate
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, invariant_ellipsoid, largest_scale
from takagi.models.embedding.coherent import LoopBox, LoopCell, Uncertainty, coherent_cells
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
    speed_error=Fraction("0.045"),
    effort_lag=Fraction("0.015"),
    speed_signal=Fraction("0.04"),
    wind_share=Fraction("0.03"),
)
DEFAULT_UNCERTAINTY = Uncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)
# Kept back from what floating point finds, so that the rounded decimals still prove.
RESERVE = 0.985
SHRINK = 1 + 1e-5


@dataclass(frozen=True, slots=True)
class WindClass:
    """The proportions in which wind error and wind rate are traded; the scale is what is proved.

    Attributes
    ----------
    wind : nodes [m/s];  error : |v - v_s| [m/s];  rate : |v_s'| [m/s^2], linear between nodes.
    """

    wind: tuple[float, ...] = (3.0, 3.5, 4.0, 6.0, 10.0, 11.5, 13.0, 25.0)
    error: tuple[float, ...] = (0.04, 0.045, 0.05, 0.064, 0.08, 0.08, 0.2, 0.3)
    rate: tuple[float, ...] = (0.003, 0.003, 0.01, 0.03, 0.03, 0.05, 0.2, 0.3)


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
    wind_class : proportions of wind error and wind rate; the default follows what torque and
        pitch can do at each wind.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : the box asks for what tables or actuators do not have; names the wind cell.
    """
    say = tell or _silent
    shape = wind_class or WindClass()
    say("enclosing the closed loop")
    cells = tuple(coherent_cells(turbine, law, box, uncertainty))
    corners = [loop_vertices(cell) for cell in cells]
    sizes = [len(v.A) for v in corners]
    middle = np.array([float(cell.wind.centre) for cell in cells])
    error = np.interp(middle, shape.wind, shape.error)
    rate = np.interp(middle, shape.wind, shape.rate)
    say("one quadratic function for all winds")
    found = invariant_ellipsoid(
        np.concatenate([v.A for v in corners]),
        np.concatenate(list(map(_disturbance, corners, error, rate))),
        np.repeat(np.arange(len(cells)), sizes),
        _directions(box),
        speed=np.repeat(law.gains.integral_rate, sizes),
    )
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
    alpha, wind_error, wind_rate, decay = _per_cell(P, cells, corners, box, error, rate)
    say("the largest common decay rate")
    settling, common = _settling(P, corners)
    return replace(
        empty,
        P=P,
        settling_P=settling,
        common_rate=common,
        multipliers=alpha,
        wind_error=wind_error,
        wind_rate=wind_rate,
        decay_rate=decay,
    )


def _settling(P: Floats, corners: list[LoopVertices]) -> tuple[Floats, float]:
    """Return the quadratic function with the largest decay rate over all corners, and the rate.

    The largest rate is a generalised eigenvalue problem; where it fails, P itself serves.
    """
    # Both signs of the disturbance share one matrix.
    A = np.concatenate([v.A[::2] for v in corners])
    answer = max_decay_rate(A)
    candidate = P if answer.P is None else np.asarray(answer.P)
    rounded = np.round(candidate * (1e3 / np.linalg.eigvalsh(candidate)[0]), 3)
    rate = RESERVE * float(decay_rates(rounded, A).min())
    return rounded, max(math.floor(rate * 1e6) / 1e6, 0.0)


def _per_cell(
    P: Floats,
    cells: tuple[LoopCell, ...],
    corners: list[LoopVertices],
    box: LoopBox,
    error: Floats,
    rate: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return multiplier, largest wind error and rate, and decay rate of each cell for this P."""
    rows = []
    for k, (cell, v) in enumerate(zip(cells, corners, strict=True)):
        limit = float(box.wind_share * cell.wind.lower) / error[k]
        scale, alpha = largest_scale(
            P, v.A, v.residual, _disturbance(v, error[k], rate[k], residual=False), limit=limit
        )
        decay = max(float(decay_rates(P, v.A).min()), 0.0)
        rows.append((alpha, RESERVE * scale * error[k], RESERVE * scale * rate[k], RESERVE * decay))
    columns = np.array(rows, dtype=np.float64).T
    return np.round(columns[0], 7), _down(columns[1]), _down(columns[2]), _down(columns[3])


def _disturbance(v: LoopVertices, error: float, rate: float, *, residual: bool = True) -> Floats:
    wind = error * v.per_wind_error + rate * v.per_wind_rate
    return np.asarray(v.residual + wind if residual else wind, dtype=np.float64)


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
    sizes = ("residual", "wind_gain", "inertia_gain", "reference_slope", "lag_slope")
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
