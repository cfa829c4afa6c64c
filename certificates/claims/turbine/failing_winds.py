"""Finds the winds at which a joint analysis fails, so that a requirement can be relaxed there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.loop_cell import LoopCell, loop_vertices


def failing_winds(cells: Sequence[LoopCell]) -> str:
    """Return, in words, the winds that prevent one quadratic function for all cells.

    Three causes are distinguished, the simplest first: a corner of a cell is unstable by itself;
    the
    corners of one cell have no common function; each cell has one, but not all have the same.
    In floating point: a hint for the user, never a claim.
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
