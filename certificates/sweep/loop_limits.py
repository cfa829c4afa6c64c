"""Finds the coefficient whose enclosure limits the loop's wind class in a range.

Each coefficient of the loop in turn is given zero width, or the value zero, and the set with the
largest wind errors is searched again.  The increase of the wind errors shows how much that
coefficient limits them.  This uses floating point and a loop other than the plant's, so it is a
hint what to change, never a claim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import cell_loops
from takagi.certificates.claims.turbine.wind_class import asked_rates
from takagi.certificates.sweep.loop_settings import LoopSettings
from takagi.certificates.sweep.widest_set import widest_functions
from takagi.certificates.sweep.wind_ranges import WindRange, law_on
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.loop_cell import LoopCell

# Coefficient -> what it is, in words.  The first five are ranges, the others sizes.
COEFFICIENTS = {
    "stiffness": "slope of torque over speed (inertia, speed error)",
    "loop_gain": "gain of the loop (inertia, pitch effectiveness, wake)",
    "lag_gain": "effect of pitch not delivered yet (wake, effort lag)",
    "share_gain": "share of pitch in the gain (overlap, speed signal)",
    "lag_rate": "pitch drive (rate limit, effort lag, wind rate)",
    "effectiveness_slope": "pitch effectiveness that moves with the wind (wind rate)",
    "reference_slope": "reference speed that moves with the wind (wind rate, torque to spare)",
    "lag_disturbance": "pitch lead that a limit cuts (wind rate)",
    "residual": "torque that the tables leave over (spacing of the nodes)",
}
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")


@dataclass(frozen=True, slots=True)
class Limit:
    """The factor on the mean wind error of a range without one coefficient's width.

    Attributes
    ----------
    coefficient : of ``COEFFICIENTS``.
    gained : the geometric mean of the wind errors over that with all widths [-].
    """

    coefficient: str
    gained: float


def what_limits(loop: LoopSettings, winds: WindRange) -> tuple[Limit, ...]:
    """Return how much each coefficient limits the wind errors of a range, the strongest first.

    Raises
    ------
    ModelError : the box leaves a table or a limit, or there is no function even with all widths.
    """
    law = law_on(loop.law, winds.low, winds.high)
    loops = cell_loops(loop.turbine, law, loop.box, loop.uncertainty)
    rates = asked_rates(loops, loop.box, loop.shape)
    cells = [each.enclosed(rate) for each, rate in zip(loops, rates, strict=True)]
    here = _mean_error(loop, cells)
    if here == 0:
        raise ModelError(
            f"{winds.words}: no quadratic function withstands a wind error in every cell at these "
            "wind rates; lower them, the box or the uncertainty"
        )
    found = [
        Limit(name, _mean_error(loop, [_without(cell, name) for cell in cells]) / here)
        for name in COEFFICIENTS
    ]
    return tuple(sorted(found, key=lambda limit: -limit.gained))


def _without(cell: LoopCell, name: str) -> LoopCell:
    """Return the cell with a range replaced by its centre, or a size replaced by zero."""
    if name in RANGES:
        middle = getattr(cell, name).centre
        changed: dict[str, Any] = {name: Interval(middle, middle)}
    else:
        changed = {name: Fraction(0)}
    return replace(cell, **changed)


def _mean_error(loop: LoopSettings, cells: Sequence[LoopCell]) -> float:
    """Return the geometric mean over wind of the admissible wind errors [m/s]; 0 for none."""
    middle = [float(cell.wind.centre) for cell in cells]
    error = np.interp(middle, loop.shape.wind, loop.shape.error)
    found = widest_functions(cells, error, loop.box)
    if found is None:
        return 0.0
    width = np.array([float(cell.wind.width) for cell in cells])
    return float(np.exp(width @ np.log(found.scales * error) / width.sum()))
