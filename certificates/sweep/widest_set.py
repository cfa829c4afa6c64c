"""The quadratic function whose set allows the largest wind errors, for some cells of the loop.

``effort_sharing_candidate`` searches the function that allows the largest fraction of the wind
class in the worst cell.  Here that function is improved further, so that the mean over wind of the
logarithms of wind errors grows (``lmi.turbine.one_step.joint_step`` with its gains fixed).
The cells may be those of a part of the winds.  The result is a candidate; the checker decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import cell_loops
from takagi.certificates.claims.turbine.failing_winds import failing_winds
from takagi.certificates.claims.turbine.largest_wind_error import (
    EffortSharingCandidate,
    RequestedLoops,
    largest_wind_errors,
)
from takagi.certificates.claims.turbine.wind_class import asked_rates, calmer
from takagi.certificates.sweep.loop_settings import LoopSettings
from takagi.lmi.analysis.invariant_ellipsoid import invariant_ellipsoid
from takagi.lmi.turbine.one_step.joint_step import Weights, joint_step
from takagi.lmi.turbine.one_step.loop_of_gains import LoopFunctions, WindCellCorners, functions_at
from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopCell, loop_vertices

# How often all rates are halved if no function exists for them, the factor of this, and how often
# a function is improved.
ATTEMPTS, CALMER, IMPROVEMENTS = 6, 0.5, 8
# An improvement of the mean by less than this ends the search.
SETTLED = 3e-3


def widest_candidate(loop: LoopSettings) -> EffortSharingCandidate:
    """Return the candidate whose function allows the largest wind errors over the law's winds.

    Raises
    ------
    ModelError : the box exceeds tables or actuator limits; names the wind cell.
    """
    on = loop.box
    loops = cell_loops(loop.turbine, loop.law, on, loop.uncertainty)
    rates = asked_rates(loops, on, loop.shape)
    middle = [float(each.wind.centre) for each in loops]
    error = np.interp(middle, loop.shape.wind, loop.shape.error)
    for attempt in range(ATTEMPTS):
        cells = [each.enclosed(rate) for each, rate in zip(loops, rates, strict=True)]
        found = widest_functions(cells, error, on)
        if found is not None:
            asked = RequestedLoops(on, loop.uncertainty, loops, rates, error)
            return largest_wind_errors(found.P, asked)
        last = attempt >= ATTEMPTS - 2
        rates = [Fraction(0) if last else calmer(rate, CALMER) for rate in rates]
    return EffortSharingCandidate.without(
        on, loop.uncertainty, cells, diagnosis=failing_winds(cells)
    )


def widest_functions(
    cells: Sequence[LoopCell], error: Floats, box: LoopBox
) -> LoopFunctions | None:
    """Return P, and the multiples of the wind errors that it allows; None if no P allows any.

    Parameters
    ----------
    cells : enclosed at the requested wind rates.
    error : (K - 1,) proportions of the wind errors [m/s].
    """
    return _Search.over(cells, error, box).widest()


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Corners of the cells at their wind rates, and the requirements on the set."""

    windy: WindCellCorners
    still: WindCellCorners
    directions: Floats
    shares: Floats
    limits: Floats
    pace: Floats

    @classmethod
    def over(cls, cells: Sequence[LoopCell], error: Floats, box: LoopBox) -> _Search:
        found = [loop_vertices(cell) for cell in cells]
        index = np.arange(len(cells))
        windy = WindCellCorners(
            np.concatenate([v.A for v in found]),
            np.concatenate([v.fixed for v in found]),
            np.concatenate([e * v.per_wind_error for v, e in zip(found, error, strict=True)]),
            np.repeat(index, [len(v.A) for v in found]),
        )
        rest = np.concatenate([v.at_rest for v in found])
        none = np.zeros((len(rest), 3))
        still = WindCellCorners(rest, none, none, np.repeat(index, [len(v.at_rest) for v in found]))
        width = np.array([float(cell.wind.width) for cell in cells])
        widest = float(box.wind_share) * np.array([float(cell.wind.lower) for cell in cells])
        return cls(
            windy,
            still,
            box.directions,
            width / width.sum(),
            widest / error,
            np.array([float(cell.integral_rate.lower) for cell in cells]),
        )

    def widest(self) -> LoopFunctions | None:
        w = self.windy
        first = invariant_ellipsoid(
            w.A, w.fixed + w.error, w.cell, self.directions, speed=self.pace[w.cell], rounds=3
        )
        if first.P is None:
            return None
        none = np.zeros(len(self.shares))
        start = LoopFunctions(np.asarray(first.P), none, none, np.eye(3), 0.0)
        best = functions_at(w, self.still, start, self.limits)
        weights = Weights(self.shares, 0.0, 0.0, np.zeros(0), self.shares)
        if best is None:
            return None
        for _ in range(IMPROVEMENTS):
            step = joint_step(w, self.still, best, self.directions, weights)
            new = None if step is None else functions_at(w, self.still, step.functions, self.limits)
            if new is None:
                break
            gained = float(self.shares @ np.log(new.scales / best.scales))
            best = new if gained > 0 else best
            if gained < SETTLED:
                break
        return best
