"""The claim about the effort-sharing loop: its enclosure, one P for all cells, its wind class.

The result is a candidate, which the checker decides.  Where there is none, texts say at which winds
the analysis fails and for which smaller uncertainty it would succeed, in floating point.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.turbine.effort_sharing.corners import BOUNDS, NODES, RANGES
from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.claims.turbine.cell_loop import (
    EffortSharingCandidate,
    WindClass,
    calmer,
    cell_loops,
    class_rates,
    largest_wind_errors,
)
from takagi.lmi.analysis.invariant_ellipsoid import Ellipsoid, invariant_ellipsoid
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.laws.effort_sharing.law import (
    EffortSharingLaw,
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
    say = tell or (lambda words: None)
    shape = wind_class or WindClass()
    say("enclosing the closed loop")
    loops = cell_loops(turbine, law, box, uncertainty)
    if rates is None:
        rates = class_rates(loops, box, shape, law.wind_filter)
    cell_rates = list(rates)
    middle = np.array([float(loop.wind.centre) for loop in loops])
    error = np.interp(middle, shape.wind, shape.error)
    asked = (box, uncertainty, loops)
    if P is not None and np.linalg.eigvalsh(P)[0] > 0 and _reaches(P, box.directions).max() <= 1:
        with_given = largest_wind_errors(P, *asked, cell_rates, error, tell=say)
        if with_given.wind_error.min() > 0:
            return with_given
    say("one quadratic function for all winds")
    candidate: EffortSharingCandidate | None = None
    for attempt in range(ATTEMPTS):
        cells = tuple(loop.enclosed(rate) for loop, rate in zip(loops, cell_rates, strict=True))
        ellipsoid = _common(cells, law, box, error)
        if ellipsoid.P is not None:
            candidate = largest_wind_errors(
                ellipsoid.P, *asked, cell_rates, error, words=ellipsoid.words, tell=say
            )
            # Where a cell bears no wind error, a function for slower winds may.
            if candidate.wind_error.min() > 0:
                return candidate
        last = attempt >= ATTEMPTS - 2
        cell_rates = [Fraction(0) if last else calmer(rate, CALMER) for rate in cell_rates]
    zeros, diagnosis = (np.zeros(len(cells)),) * 4, ellipsoid.diagnosis
    return candidate or EffortSharingCandidate(
        box, uncertainty, cells, None, *zeros, np.eye(3), 0.0, diagnosis, ellipsoid.words
    )


def _common(
    cells: tuple[LoopCell, ...], law: EffortSharingLaw, box: LoopBox, error: Floats
) -> Ellipsoid:
    """Return one invariant ellipsoid for all cells, each at its own wind rate."""
    corners = [loop_vertices(cell) for cell in cells]
    sizes = [len(v.A) for v in corners]
    d = [v.fixed + size * v.per_wind_error for v, size in zip(corners, error, strict=True)]
    return invariant_ellipsoid(
        np.concatenate([v.A for v in corners]),
        np.concatenate(d),
        np.repeat(np.arange(len(cells)), sizes),
        box.directions,
        speed=np.repeat(law.gains.integral_rate, sizes),
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
        "box": {side.name: float(getattr(box, side.name)) for side in fields(box)},
        "P": candidate.P.tolist(),
        "peaks": _peaks(candidate.P),
        "settling": {"P": candidate.settling_P.tolist(), "decay_rate": candidate.common_rate},
        "cells": [_cell(candidate, k) for k in range(len(cells))],
    }


def _name(candidate: EffortSharingCandidate) -> str:
    """Return the claim's name in the checker's words, rounded so that it does not claim more."""
    cells = candidate.cells
    low, high = exact(float(cells[0].wind.lower)), exact(float(cells[-1].wind.upper))
    lowest = min(exact(float(cell.effectiveness_limit.lower)) for cell in cells)
    highest = max(exact(float(cell.effectiveness_limit.upper)) for cell in cells)
    wake = "equilibrium wake"
    if candidate.uncertainty.frozen_wake and lowest > 0:
        reach = f"{at_least(lowest, 3)} to {at_least(highest, 3)} rad/s^2 per rad"
        wake = f"pitch effectiveness up to {reach}"
    return f"effort-sharing loop, {at_most(low, 6)} to {at_least(high, 6)} m/s, {wake}"


def _peaks(P: Floats) -> dict[str, float]:
    """Return max |h x| over x'Px <= 1 = sqrt(h P^-1 h'), rounded up."""
    names = ("speed_error", "effort_lag", "speed_signal", "integral")
    reaches = np.sqrt(_reaches(P, np.array([[1, 0, 0], [0, 1, 0], [1, 0, -1], [0, 0, 1]])))
    # Rounded up after a small margin, because the exact peak must not exceed the stated one.
    peaks = np.ceil(reaches * (1 + 1e-6) * 1e7) / 1e7
    return dict(zip(names, peaks.tolist(), strict=True))


def _reaches(P: Floats, rows: Floats) -> Floats:
    """Return h P^-1 h' of each row, the square of the largest h x over the set of P."""
    return np.asarray(np.einsum("di,ij,dj->d", rows, np.linalg.inv(P), rows))


def _cell(candidate: EffortSharingCandidate, k: int) -> dict[str, Any]:
    cell = candidate.cells[k]
    ranges: dict[str, Interval] = {name: getattr(cell, name) for name in (*NODES, *RANGES)}
    stated: dict[str, Any] = {
        name: [float(range_.lower), float(range_.upper)] for name, range_ in ranges.items()
    }
    stated |= {name: float(getattr(cell, name)) for name in BOUNDS}
    stated["integral_rate"] = float(cell.integral_rate.lower)
    stated["multiplier"] = float(candidate.multipliers[k])
    for name in ("wind_error", "wind_rate", "decay_rate"):
        stated[name] = float(getattr(candidate, name)[k])
    return stated


# Fractions of the requested interval's excess over 1 that are tried, the largest first.
SHARES = (Fraction(1, 2), Fraction(1, 4), Fraction(1, 8), Fraction(1, 16))
DIGITS = 3


def why_not_proved(candidate: EffortSharingCandidate) -> str:
    """Return, in words, the winds of a candidate that are not proved, and why; empty for none."""
    if candidate.P is None:
        reason = failing_winds(candidate.cells)
        return f"no common quadratic function over all winds was found; {reason}"
    pairs = zip(candidate.cells, candidate.wind_error, strict=True)
    unproved = [cell for cell, error in pairs if not error > 0]
    if not unproved:
        return ""
    return (
        f"the common quadratic function allows no wind error in {len(unproved)} of "
        f"{len(candidate.cells)} wind cells: {', '.join(map(_span, unproved[:3]))} m/s"
        f"{' and more' if len(unproved) > 3 else ''}"
    )


def failing_winds(cells: Sequence[LoopCell]) -> str:
    """Return, in words, the winds that prevent one quadratic function for all cells.

    Three causes are distinguished, the simplest first: a corner of a cell is unstable by itself;
    the corners of one cell have no common function; each cell has one, but not all have the same.
    """
    corners = [loop_vertices(cell).A for cell in cells]
    growth = [float(np.linalg.eigvals(A).real.max()) for A in corners]
    worst = int(np.argmax(growth))
    if growth[worst] >= 0:
        bad = [cell for cell, rate in zip(cells, growth, strict=True) if rate >= 0]
        return (
            f"the loop itself may be unstable in {len(bad)} of {len(cells)} wind cells ("
            f"{float(bad[0].wind.lower):g} to {float(bad[-1].wind.upper):g} m/s); worst at wind "
            f"{_span(cells[worst])} m/s, where a deviation may grow at {growth[worst]:.3g} 1/s"
        )
    for cell, A in zip(cells, corners, strict=True):
        if not _has_function(A):
            return (
                f"at wind {_span(cell)} m/s alone no quadratic function serves all the loop's "
                "corners"
            )

    def lost(count: int) -> bool:
        return not _has_function(np.concatenate(corners[:count]))

    # How many cells, counted from the lowest wind, share one function.
    reach = bisect_left(range(1, len(cells) + 1), True, key=lost)
    if reach == len(cells):
        return (
            "a common quadratic function exists, but its set does not stay inside the box under "
            "the tables' residual and the wind limits"
        )
    return (
        f"every wind has its quadratic function, but one for all is lost when winds up to "
        f"{float(cells[reach].wind.upper):g} m/s are joined to those from "
        f"{float(cells[0].wind.lower):g} m/s"
    )


def _has_function(A: Floats) -> bool:
    """Return whether floating point finds one P with A'P + PA < 0 at all corners."""
    from takagi.lmi.analysis.common_quadratic import common_lyapunov

    return common_lyapunov(A).P is not None


def _span(cell: LoopCell) -> str:
    return f"{float(cell.wind.lower):g} to {float(cell.wind.upper):g}"


def smaller_uncertainty(
    turbine: Turbine, law: EffortSharingLaw, box: LoopBox, uncertainty: LoopUncertainty
) -> str:
    """Return, in words, a part of the uncertainty for which all winds are proved.

    It tries an inertia interval of a half to a sixteenth of the excess over nominal, then only the
    wake of the surface. It uses floating point and the given gains. Empty if none of them helps.
    """

    def helps(smaller: LoopUncertainty) -> bool:
        candidate = effort_sharing_candidate(turbine, law, box=box, uncertainty=smaller)
        return not why_not_proved(candidate)

    span = uncertainty.inertia
    for share in SHARES if span.width else ():
        # A fraction of each side's width about 1, rounded towards 1.
        below, above = (int(abs(end - 1) * share * 10**DIGITS) for end in (span.lower, span.upper))
        narrow = Interval(1 - Fraction(below, 10**DIGITS), 1 + Fraction(above, 10**DIGITS))
        if helps(replace(uncertainty, inertia=narrow)):
            low, high = float(narrow.lower), float(narrow.upper)
            return f"with these gains inertia {low:g} to {high:g} of nominal would do"
    if uncertainty.frozen_wake and helps(replace(uncertainty, frozen_wake=False)):
        return "without the frozen wake it would do: lower the file's sensitivity or factor"
    return ""


LARGER_PITCHES = (1.0, 2.0)


def larger_least_pitch(
    turbine: Turbine,
    remade: Callable[[Turbine], EffortSharingLaw],
    box: LoopBox,
    uncertainty: LoopUncertainty,
) -> str:
    """Return, in words, a smallest pitch for which all winds are proved; empty if none was found.

    ``remade`` : returns the law of the turbine with another smallest pitch, with gains of its own.
    """
    for increase in LARGER_PITCHES:
        pitch = math.floor(math.degrees(turbine.pitch_min) + increase + 1e-9)
        with_pitch = replace(turbine, pitch_min=math.radians(pitch))
        try:
            law = remade(with_pitch)
            candidate = effort_sharing_candidate(with_pitch, law, box=box, uncertainty=uncertainty)
        except ModelError:
            continue  # No trim, no gain, or a box that leaves the table, with this angle.
        if not why_not_proved(candidate):
            return f"a smallest pitch of {pitch:g} deg would do (pitch.minimum of the file)"
    return ""
