"""Ranges of the torque coefficient for a search: ``patch_ranges`` between rational numbers.

The ranges are right up to rounding, so they are not rigorous bounds. A result that a search finds
with them is enclosed rigorously before anything is claimed.
"""

from __future__ import annotations

from collections.abc import Callable

from takagi.models.intervals.interval import Interval
from takagi.models.splines.patch_ranges import patch_ranges
from takagi.models.splines.surface import Surface

# An end on the table's edge may be rounded to a point outside.
EDGE = 1e-12


def quick_ranges(surface: Surface) -> Callable[[Interval, Interval, int, int], Interval]:
    """Return a function of (x, y, dx, dy) to put in the place of ``surface.bounds``.

    It raises ModelError where the rectangle leaves the table.
    """
    found = patch_ranges(surface)

    def ranges(x: Interval, y: Interval, dx: int, dy: int) -> Interval:
        across, along = _ends(x, surface.x_range), _ends(y, surface.y_range)
        return Interval.of(*found(across, along, ((dx, dy),))[0])

    return ranges


def _ends(over: Interval, table: tuple[float, float]) -> tuple[float, float]:
    low, high = float(over.lower), float(over.upper)
    first, last = table
    return (
        first if first - EDGE < low < first else low,
        last if last < high < last + EDGE else high,
    )
