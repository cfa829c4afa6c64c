r"""The effort-sharing loop as a function of its gains: corners of every wind cell and their slopes.

Near given gains, every corner is a linear function of the logarithms of its cell's three gains:
gamma at the cell's two ends and nu in the cell.  The ends of the enclosures are minima and maxima,
which have kinks.  Each gamma therefore has two secants, one for larger and one for smaller gains,
and every combination of secants is a corner.  This is conservative at a kink.  Elsewhere both
secants agree to first order, and nearly equal corners are removed.

The linear functions are not bounds: the gains that a step proposes are enclosed again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, largest_scale, slacks
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    loop_vertices,
)
from takagi.models.turbine.data import Turbine


@dataclass(frozen=True, slots=True, eq=False)
class LoopFunctions:
    """The quadratic functions found at given gains.

    Attributes
    ----------
    P : (3, 3); the set {x' P x <= 1} is invariant and inside the box.
    multipliers : (K - 1,) alpha of the invariance inequality, one for each cell.
    scales : (K - 1,) multiple of the requested wind error for which P is invariant in each cell.
    R : (3, 3); x' R x decays at ``decay_rate`` [1/s] while the wind is constant.
    """

    P: Floats
    multipliers: Floats
    scales: Floats
    R: Floats
    decay_rate: float


def reached_by_function(P: Floats, directions: Floats) -> Floats:
    """Return (D,): the maximum of (h_i' x)^2 over x' P x <= 1, which is h_i' P^-1 h_i."""
    return np.asarray(np.einsum("di,ij,dj->d", directions, np.linalg.inv(P), directions))


def functions_at(
    corners: WindCellCorners, calm: WindCellCorners, functions: LoopFunctions, limit: Floats
) -> LoopFunctions | None:
    """Return the functions with multiples and decay rate recomputed at these corners.

    ``functions`` : P with its set inside the box, and R.  Its multiples and multipliers are kept
    where they hold at the corners and are better than the result of the search over multipliers;
    zeros if there are none.
    ``limit`` : (K - 1,) largest multiple for which the corners are valid.

    None if a cell tolerates no wind error.
    """
    multiples = []
    for k, largest in enumerate(limit):
        mine = corners.cell == k
        A, fixed, error = corners.A[mine], corners.fixed[mine], corners.error[mine]
        best = largest_scale(functions.P, A, fixed, error, limit=largest)
        scale, alpha = min(functions.scales[k], largest), functions.multipliers[k]
        # The search over alpha is one-dimensional and approximate; the step's own alpha may be
        # better.  It counts only if its inequalities hold at the true corners.
        if scale > best[0] and alpha > 0:
            cell_slacks = slacks(functions.P, A, fixed + scale * error, np.full(len(A), alpha))
            best = (scale, alpha) if cell_slacks.max() < 0 else best
        multiples.append(best)
    scales, multipliers = np.array(multiples).T
    decay = float(decay_rates(functions.R, calm.A).min())
    if scales.min() <= 0:
        return None
    return replace(functions, scales=scales, multipliers=multipliers, decay_rate=decay)


# Decimals of the gains during the search.  Gains are rounded to fewer decimals only at its end.
DECIMALS = 8
# Width given to a range that is a single point.  Every cell then has the same number of corners at
# all gains, so that differences between corners of two gains are defined.
OPENED = Fraction(1, 10**12)
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
# Corners that agree within this share of the largest entry are merged, in the search alone.
SAME = 1e-2
# In cells of this width [m/s] and wider, gamma may change by the whole trust region from one end to
# the other; in narrower cells by less (``bends``).
FULL_WIDTH = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class WindCellCorners:
    """Corners of all cells at given gains.

    Attributes
    ----------
    A : (N, 3, 3) loop matrices.
    fixed : (N, 3) disturbance by the residual of the trim tables and by the wind rate.
    error : (N, 3) disturbance by the requested wind error.
    cell : (N,) wind cell of each corner.
    """

    A: Floats
    fixed: Floats
    error: Floats
    cell: Indices


@dataclass(frozen=True, slots=True, eq=False)
class MovingCorners:
    """Corners with their secants in the logarithms u of the gains.

    Attributes
    ----------
    at : the corners at u = 0.
    members : (N, 3) indices of the gains that a corner depends on: gamma at both ends, then nu.
    A : (N, 3, 3, 3);  fixed, error : (N, 3, 3);  changes per unit of each of these logarithms.
    """

    at: WindCellCorners
    members: Indices
    A: Floats
    fixed: Floats
    error: Floats

    @classmethod
    def still(cls, at: WindCellCorners) -> MovingCorners:
        """Return corners with zero secants, for a step with fixed gains."""
        count = len(at.A)
        members, none = np.zeros((count, 3), dtype=np.intp), np.zeros((count, 3, 3))
        return cls(at, members, np.zeros((count, 3, 3, 3)), none, none)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LoopOfGains:
    """The closed loop as a function of its gains: turbine, law, box and wind class.

    The gains form one row theta of G = 2K - 1 numbers: gamma at the K nodes, then nu of the K - 1
    cells.

    Attributes
    ----------
    law : law whose schedule is used; theta replaces its gains.
    error : (K - 1,) |v - v_s| of each cell [m/s], its part of the wind class.
    enclosed : encloses one cell, at its wind rate, with given gains and the cell's number; raises
        ModelError where these gains make the cell leave a table or an actuator limit.
    """

    turbine: Turbine
    law: EffortSharingLaw
    box: LoopBox
    error: Floats
    enclosed: Callable[[EffortGains, int], LoopCell]

    def __post_init__(self) -> None:
        if len(self.error) != self.cells:
            raise ModelError(
                f"error has {len(self.error)} entries for {self.cells} wind cells; give one for "
                "each"
            )

    @property
    def cells(self) -> int:
        """Return the number of wind cells, K - 1."""
        return len(self.law.schedule.wind) - 1

    def at(self, theta: Floats) -> EffortSharingLaw:
        """Return the law with these gains."""
        nodes = self.cells + 1
        gains = EffortGains(np.round(theta[:nodes], DECIMALS), np.round(theta[nodes:], DECIMALS))
        return replace(self.law, gains=gains)

    def corners(self, theta: Floats) -> tuple[WindCellCorners, WindCellCorners]:
        """Return the corners of all cells under the wind class, and undisturbed.

        Raises
        ------
        ModelError : at these gains a cell leaves a table or an actuator limit; the message names
            the cell.
        """
        gains = self.at(theta).gains
        cells = [self._rows(self.enclosed(gains, k), k) for k in range(self.cells)]
        windy, calm = ([_distinct(cell[i]) for cell in cells] for i in (0, 1))
        return _gathered(windy), _gathered(calm)

    def moving(
        self, theta: Floats, reach: float
    ) -> tuple[MovingCorners, MovingCorners, NDArray[np.bool_]]:
        """Return the corners with their secants, and the directions in which gains may change.

        ``reach`` : change of each logarithm between the two ends of a secant; it is smaller in
        narrow cells (``bends``).

        Corners under the wind class, undisturbed corners, and (G, 2) booleans for a smaller and a
        larger gain: False if that change makes a cell leave a table or a limit.
        """
        free = np.ones((len(theta), 2), dtype=np.bool_)
        spans = self.bends(reach)
        cells = [self._moving(theta, k, float(spans[k]), free) for k in range(self.cells)]
        windy, calm = ([cell[i] for cell in cells] for i in (0, 1))
        return self._spread(windy), self._spread(calm), free

    def bends(self, reach: float) -> Floats:
        """Return (K - 1,): the largest difference of log gamma's change between a cell's ends.

        In a narrow cell a small difference makes d gamma / d v_s large, and the pitch lead must
        follow that slope.
        """
        widths = np.diff(self.law.schedule.wind)
        return np.asarray(reach * np.minimum(1.0, widths / FULL_WIDTH), dtype=np.float64)

    def _rows(self, cell: LoopCell, k: int) -> tuple[Floats, Floats]:
        """Return (A, fixed, error) of each corner as rows of 15; as many rows at all gains."""
        vertices = loop_vertices(_opened(cell))
        error = self.error[k] * vertices.per_wind_error
        calm_rows = vertices.at_rest.reshape(-1, 9)
        return (
            np.concatenate([vertices.A.reshape(-1, 9), vertices.fixed, error], axis=1),
            np.concatenate([calm_rows, np.zeros((len(calm_rows), 6))], axis=1),
        )

    def _moving(
        self, theta: Floats, k: int, reach: float, free: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Return rows of 60: a corner and its three secants, for each combination of secants."""
        cell = self.enclosed(self.at(theta).gains, k)
        here = self._rows(cell, k)
        secants: list[list[tuple[Floats, ...]]] = []
        for number, member in enumerate((k, k + 1, self.cells + 1 + k)):
            changes = []
            for side in (-1, 1) if number < 2 else (-1,):
                try:
                    there = self._rows(self._beside(theta, k, member, side * reach, cell), k)
                except ModelError:
                    free[member, (1 + side) // 2] = False
                    continue
                change = [(b - a) / (side * reach) for a, b in zip(here, there, strict=True)]
                changes.append(tuple(change))
            secants.append(changes or [tuple(np.zeros_like(corner) for corner in here)])
        windy, calm = (
            _apart(
                np.concatenate(
                    [
                        np.concatenate([here[i], *(secant[i] for secant in row)], axis=1)
                        for row in product(*secants)
                    ]
                )
            )
            for i in (0, 1)
        )
        return windy, calm

    def _beside(
        self, theta: Floats, k: int, member: int, change: float, cell: LoopCell
    ) -> LoopCell:
        """Return the cell after a change of one gain's logarithm.

        A change of nu changes only the range of nu itself, so the cell is not enclosed again.
        """
        beside = theta.copy()
        beside[member] *= np.exp(change)
        gains = self.at(beside).gains
        if member <= self.cells:
            return self.enclosed(gains, k)
        rate = Interval.of(float(gains.integral_rate[k]))
        return replace(cell, integral_rate=rate)

    def _spread(self, cell_rows: list[Floats]) -> MovingCorners:
        rows = np.concatenate(cell_rows).reshape(-1, 4, 15)
        A, fixed, error = rows[:, :, :9].reshape(-1, 4, 3, 3), rows[:, :, 9:12], rows[:, :, 12:]
        cell = np.repeat(np.arange(self.cells), [len(rows_of_cell) for rows_of_cell in cell_rows])
        members = np.stack([cell, cell + 1, self.cells + 1 + cell], axis=1)
        at = WindCellCorners(A[:, 0], fixed[:, 0], error[:, 0], cell)
        return MovingCorners(at, members, A[:, 1:], fixed[:, 1:], error[:, 1:])


def _distinct(rows: Floats) -> Floats:
    """Return the rows without duplicates; rounding removes the differences from ``_opened``."""
    return np.asarray(rows[np.unique(np.round(rows, 10), axis=0, return_index=True)[1]])


def _apart(rows: Floats) -> Floats:
    """Return the rows after merging those that agree within SAME of each column's largest entry."""
    size = np.abs(rows).max(axis=0)
    rough = np.round(rows / (SAME * np.where(size > 0, size, 1.0)))
    return np.asarray(rows[np.unique(rough, axis=0, return_index=True)[1]])


def _gathered(cell_rows: list[Floats]) -> WindCellCorners:
    rows = np.concatenate(cell_rows)
    cell = np.repeat(np.arange(len(cell_rows)), [len(rows_of_cell) for rows_of_cell in cell_rows])
    return WindCellCorners(rows[:, :9].reshape(-1, 3, 3), rows[:, 9:12], rows[:, 12:], cell)


def _opened(cell: LoopCell) -> LoopCell:
    """Return the cell with the width OPENED in ranges of one point and for a zero disturbance."""
    changed: dict[str, Interval | Fraction] = {}
    for name in RANGES:
        value: Interval = getattr(cell, name)
        if value.lower == value.upper:
            changed[name] = Interval(value.lower, value.upper + OPENED)
    if cell.lag_disturbance == 0:
        changed["lag_disturbance"] = OPENED
    return replace(cell, **changed)  # type: ignore[arg-type]
