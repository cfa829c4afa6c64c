"""The claim about the effort-sharing loop: its enclosure, one P for all cells, its wind class.

Nothing is proved here.  The result is a candidate claim; ``takagi.certificates.checker`` decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.claims.turbine.cell_loop import cell_loops
from takagi.certificates.claims.turbine.largest_wind_error import (
    EffortSharingCandidate,
    RequestedLoops,
    largest_wind_errors,
)
from takagi.certificates.claims.turbine.wind_class import WindClass, asked_rates, calmer
from takagi.lmi.analysis.invariant_ellipsoid import Ellipsoid, invariant_ellipsoid
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import (
    LoopBox,
    LoopCell,
    LoopUncertainty,
    loop_vertices,
)
from takagi.models.turbine.data import Turbine

Tell = Callable[[str], None]

DEFAULT_BOX = LoopBox(
    speed_error=Fraction("0.04"),
    effort_lag=Fraction("0.008"),
    speed_signal=Fraction("0.03"),
    wind_share=Fraction("0.03"),
)
DEFAULT_UNCERTAINTY = LoopUncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)
# If no quadratic function exists, all rates are lowered by this factor, at most so often.
CALMER, ATTEMPTS = 0.5, 6


def effort_sharing_candidate(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    box: LoopBox = DEFAULT_BOX,
    uncertainty: LoopUncertainty = DEFAULT_UNCERTAINTY,
    wind_class: WindClass | None = None,
    P: Floats | None = None,
    rates: Sequence[Fraction] | None = None,
    tell: Tell | None = None,
) -> EffortSharingCandidate:
    """Return the candidate certificate of the effort-sharing loop: one P for all winds and corners.

    Parameters
    ----------
    box : the region around the trim that is enclosed.
    wind_class : wind rates asked for, and proportions of wind errors; the default follows what
        torque and pitch can do at each wind.
    P : (3, 3) from another search, its set inside the box; for None, or if it does not hold in all
        cells, P is searched here.
    rates : |v_s'| of each cell [m/s^2] to try; None takes those of the wind class.
    tell : called with a message on progress.

    Raises
    ------
    ModelError : the box exceeds tables or actuator limits; names the wind cell.
    """
    say = tell or _silent
    shape = wind_class or WindClass()
    say("enclosing the closed loop")
    loops = cell_loops(turbine, law, box, uncertainty)
    asked = asked_rates(loops, box, shape) if rates is None else list(rates)
    middle = np.array([float(loop.wind.centre) for loop in loops])
    error = np.interp(middle, shape.wind, shape.error)
    if P is not None and _inside(P, box):
        given = largest_wind_errors(
            P, RequestedLoops(box, uncertainty, loops, asked, error), tell=say
        )
        if given.wind_error.min() > 0:
            return given
    say("one quadratic function for all winds")
    for attempt in range(ATTEMPTS):
        cells = tuple(loop.enclosed(rate) for loop, rate in zip(loops, asked, strict=True))
        found = _common(cells, law, box, error)
        if found.P is not None:
            break
        last = attempt >= ATTEMPTS - 2
        asked = [Fraction(0) if last else calmer(rate, CALMER) for rate in asked]
    if found.P is not None:
        loops_asked = RequestedLoops(box, uncertainty, loops, asked, error)
        return largest_wind_errors(found.P, loops_asked, words=found.words, tell=say)
    return EffortSharingCandidate.without(
        box, uncertainty, cells, diagnosis=found.diagnosis, words=found.words
    )


def _common(
    cells: tuple[LoopCell, ...], law: EffortSharingLaw, box: LoopBox, error: Floats
) -> Ellipsoid:
    """Return one invariant ellipsoid for all cells, each at its own wind rate."""
    corners = [loop_vertices(cell) for cell in cells]
    sizes = [len(v.A) for v in corners]
    d = [v.fixed + each * v.per_wind_error for v, each in zip(corners, error, strict=True)]
    return invariant_ellipsoid(
        np.concatenate([v.A for v in corners]),
        np.concatenate(d),
        np.repeat(np.arange(len(cells)), sizes),
        box.directions,
        speed=np.repeat(law.gains.integral_rate, sizes),
    )


def _inside(P: Floats, box: LoopBox) -> bool:
    """Return whether {x' P x <= 1} lies inside the box."""
    h = box.directions
    return float(np.linalg.eigvalsh(P)[0]) > 0 and bool(
        np.all(np.einsum("di,ij,dj->d", h, np.linalg.inv(P), h) <= 1)
    )


def effort_sharing_claim(candidate: EffortSharingCandidate) -> dict[str, Any]:
    """Return the claim as plain data; numbers are decimals, written as they are proved.

    Raises
    ------
    ModelError : the candidate has no P.
    """
    if candidate.P is None:
        raise ModelError(f"there is no candidate to state: {candidate.diagnosis}")
    box, cells = candidate.box, candidate.cells
    inertia, power = candidate.uncertainty.inertia, candidate.uncertainty.power_coefficient
    return {
        "name": _name(candidate),
        "kind": "coherent-loop",
        "state": ["speed error [rad/s]", "effort lag [rad/s^2]", "speed integral [rad/s]"],
        "uncertainty": {
            "inertia": [float(inertia.lower), float(inertia.upper)],
            "frozen_wake": candidate.uncertainty.frozen_wake,
            "power_coefficient": [float(power.lower), float(power.upper)],
        },
        "box": {
            "speed_error": float(box.speed_error),
            "effort_lag": float(box.effort_lag),
            "speed_signal": float(box.speed_signal),
            "wind_share": float(box.wind_share),
        },
        "P": candidate.P.tolist(),
        "peaks": _peaks(candidate.P),
        "settling": {"P": candidate.settling_P.tolist(), "decay_rate": candidate.common_rate},
        "cells": [_cell(candidate, k) for k in range(len(cells))],
    }


def _name(candidate: EffortSharingCandidate) -> str:
    """Return the claim's name in the checker's words, rounded so that it does not claim more."""
    cells = candidate.cells
    low, high = _stated(cells[0].wind.lower), _stated(cells[-1].wind.upper)
    least = min(_stated(cell.effectiveness_limit.lower) for cell in cells)
    most = max(_stated(cell.effectiveness_limit.upper) for cell in cells)
    wake = "equilibrium wake"
    if candidate.uncertainty.frozen_wake and least > 0:
        reach = f"{at_least(least, 3)} to {at_least(most, 3)} rad/s^2 per rad"
        wake = f"pitch effectiveness up to {reach}"
    return f"effort-sharing loop, {at_most(low, 6)} to {at_least(high, 6)} m/s, {wake}"


def _stated(value: Fraction) -> Fraction:
    """Return the decimal that is written to the file for a number."""
    return Fraction(repr(float(value)))


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
        # Rounded up after a small margin, because the exact peak must not exceed the stated one.
        name: math.ceil(float(np.sqrt(h @ inverse @ h)) * (1 + 1e-6) * 1e7) / 1e7
        for name, h in rows.items()
    }


def _cell(candidate: EffortSharingCandidate, k: int) -> dict[str, Any]:
    cell = candidate.cells[k]
    nodes = ("wind", "effectiveness_limit")
    ranges = (*nodes, "stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
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
    """Ignore the progress message."""
