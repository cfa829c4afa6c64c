"""Why a joint analysis fails, in words: at which winds, and which smaller uncertainty it covers.

In floating point: hints for the user on what to relax, never a claim.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_candidate
from takagi.models.arrays import Floats
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import (
    LoopBox,
    LoopCell,
    LoopUncertainty,
    loop_vertices,
)
from takagi.models.turbine.data import Turbine

# Fractions of the requested interval's excess over 1 that are tried, the largest first.
SHARES = (Fraction(1, 2), Fraction(1, 4), Fraction(1, 8), Fraction(1, 16))
DIGITS = 3


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
            f"the loop itself may be unstable in {_count(bad, len(cells))}; worst at wind "
            f"{_span(cells[worst])} m/s, where a deviation may grow at {growth[worst]:.3g} 1/s"
        )
    for cell, A in zip(cells, corners, strict=True):
        if not _common(A):
            return (
                f"at wind {_span(cell)} m/s alone no quadratic function serves all the loop's "
                "corners"
            )
    reach = _longest_prefix(corners)
    if reach == len(cells):
        return (
            "a common quadratic function exists, but its set does not stay inside the box under "
            "the tables' residual and the wind class"
        )
    return (
        f"every wind has its quadratic function, but one for all is lost when winds up to "
        f"{float(cells[reach].wind.upper):g} m/s are joined to those from "
        f"{float(cells[0].wind.lower):g} m/s"
    )


def _common(A: Floats) -> bool:
    """Return whether floating point finds one P with A'P + PA < 0 at all corners."""
    from takagi.lmi.analysis.common_quadratic import common_lyapunov

    return common_lyapunov(A).P is not None


def _longest_prefix(corners: Sequence[Floats]) -> int:
    """Return how many cells, counted from the lowest wind, share one function; by bisection."""
    low, high = 1, len(corners) + 1
    while high - low > 1:
        middle = (low + high) // 2
        if _common(np.concatenate(corners[:middle])):
            low = middle
        else:
            high = middle
    return low


def _span(cell: LoopCell) -> str:
    return f"{float(cell.wind.lower):g} to {float(cell.wind.upper):g}"


def _count(bad: Sequence[LoopCell], total: int) -> str:
    low, high = float(bad[0].wind.lower), float(bad[-1].wind.upper)
    return f"{len(bad)} of {total} wind cells ({low:g} to {high:g} m/s)"


def smaller_uncertainty(
    turbine: Turbine, law: EffortSharingLaw, box: LoopBox, uncertainty: LoopUncertainty
) -> str:
    """Return, in words, a part of the uncertainty for which a common function is found.

    It tries an inertia interval of a half to a sixteenth of the excess over nominal, then only the
    wake of the surface. It uses floating point and the given gains. Empty if none of them helps.
    """
    span = uncertainty.inertia
    for share in SHARES if span.width else ():
        narrow = _narrowed(span, share)
        smaller = LoopUncertainty(narrow, uncertainty.frozen_wake, uncertainty.power_coefficient)
        if effort_sharing_candidate(turbine, law, box=box, uncertainty=smaller).P is not None:
            low, high = float(narrow.lower), float(narrow.upper)
            return f"with these gains inertia {low:g} to {high:g} of nominal would do"
    if uncertainty.frozen_wake:
        smaller = LoopUncertainty(
            span, frozen_wake=False, power_coefficient=uncertainty.power_coefficient
        )
        if effort_sharing_candidate(turbine, law, box=box, uncertainty=smaller).P is not None:
            return "without the frozen wake it would do: lower the file's sensitivity or factor"
    return ""


def _narrowed(span: Interval, share: Fraction) -> Interval:
    """Return the interval around 1 with a fraction of each side's width, rounded towards 1."""
    scale = 10**DIGITS
    low, high = (1 - span.lower) * share * scale, (span.upper - 1) * share * scale
    return Interval(1 - Fraction(int(low), scale), 1 + Fraction(int(high), scale))
