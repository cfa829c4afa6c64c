r"""The coherent loop as a function of its gains: corners of every wind cell, and how they move.

Around given gains every corner is replaced by straight lines in the logarithms of its cell's three
gains: gamma at the cell's two ends and nu in it.  The enclosures' ends are minima and maxima, with
kinks, so each gamma has two secants, one upwards and one downwards; all their combinations are
corners of their own.  That leans to the safe side at a kink and costs nothing elsewhere, where
both are the same and drop out.

Nothing here is a bound: gains that a step proposes are enclosed anew.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from fractions import Fraction
from itertools import product

import numpy as np
from numpy.typing import NDArray

from takagi.models.embedding.coherent import LoopBox, LoopCell, Uncertainty, coherent_cells
from takagi.models.embedding.vertices import loop_vertices
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError
from takagi.models.law.coherent import CoherentLaw, EffortGains
from takagi.models.law.schedule import EffortSchedule
from takagi.models.turbine.data import Turbine

__all__ = ["Corners", "LoopFamily", "Moving"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

# Decimals of the gains within the search; those that are emitted are rounded at its end.
DECIMALS = 8
# Opens a range that is one point, so that a cell has the same corners at any gains.
OPENED = Fraction(1, 10**12)
NOT_CORNERS = ("wind", "integral_rate", "speed", "torque", "pitch")
# Corners that differ by less than this share of the largest entry are one.
SAME = 1e-2


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Corners of all cells at given gains.

    Attributes
    ----------
    A : (N, 3, 3);  d : (N, 3), the disturbance of the whole wind class;  cell : (N,).
    """

    A: Floats
    d: Floats
    cell: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """Corners with their secants in the logarithms u of the gains.

    Attributes
    ----------
    at : the corners.
    members : (N, 3) which of the G gains move a corner: gamma at both ends, then nu.
    A, d : (N, 3, 3, 3), (N, 3, 3) change of A and d per unit of each.
    raised : (G,) whether a gain may be raised at all: no cell leaves a table or a limit by it.
    """

    at: Corners
    members: Indices
    A: Floats
    d: Floats
    raised: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LoopFamily:
    """What stays the same while gains are sought.

    Gains are one row theta of G = 2K - 1 numbers: gamma at the K nodes, then nu of the K - 1 cells.

    Attributes
    ----------
    boxes : of each cell.
    error, rate : (K - 1,) the wind class: |v - v_s| [m/s] and |v_s'| [m/s^2] of each cell.
    """

    turbine: Turbine
    schedule: EffortSchedule
    boxes: tuple[LoopBox, ...]
    uncertainty: Uncertainty
    error: Floats
    rate: Floats

    def __post_init__(self) -> None:
        cells = len(self.schedule.wind) - 1
        for name in ("boxes", "error", "rate"):
            if len(getattr(self, name)) != cells:
                raise ModelError(
                    f"{name} has {len(getattr(self, name))} entries for {cells} wind cells; "
                    "give one for each"
                )

    @property
    def cells(self) -> int:
        """Return the number of wind cells, K - 1."""
        return len(self.boxes)

    def law(self, theta: Floats) -> CoherentLaw:
        """Return the law with these gains."""
        nodes = self.cells + 1
        gains = EffortGains(np.round(theta[:nodes], DECIMALS), np.round(theta[nodes:], DECIMALS))
        return CoherentLaw.of(self.turbine, self.schedule, gains)

    def corners(self, theta: Floats) -> Corners:
        """Return the corners of all cells.

        Raises
        ------
        ModelError : a cell leaves a table or an actuator's limit at these gains; names the cell.
        """
        return _joined([self._distinct(*self._cell(theta, k), k) for k in range(self.cells)])

    def moving(self, theta: Floats, reach: float) -> Moving:
        """Return the corners with their secants over changes of ``reach`` in the logarithms."""
        raised = np.ones(len(theta), dtype=np.bool_)
        parts = [self._moving(theta, k, reach, raised) for k in range(self.cells)]
        flat = [np.concatenate(column) for column in zip(*parts, strict=True)]
        A, d, cell, members, dA, dd = flat
        return Moving(Corners(A, d, cell), members, dA, dd, raised)

    def members(self, k: int) -> tuple[int, int, int]:
        """Return the gains of cell k in theta."""
        return k, k + 1, self.cells + 1 + k

    def _cell(self, theta: Floats, k: int) -> tuple[Floats, Floats]:
        """Return A and d of all corners of cell k, as many at any gains."""
        low, high, inside = theta[list(self.members(k))]
        gains = EffortGains(
            np.round([low, high], DECIMALS), np.round([inside], DECIMALS)
        )
        law = CoherentLaw.of(self.turbine, _slice(self.schedule, k), gains)
        (cell,) = coherent_cells(self.turbine, law, self.boxes[k], self.uncertainty)
        found = loop_vertices(_opened(cell))
        wind = self.error[k] * found.per_wind_error + self.rate[k] * found.per_wind_rate
        return found.A, found.residual + wind

    def _distinct(self, A: Floats, d: Floats, k: int) -> Corners:
        rows = np.unique(np.concatenate([A.reshape(len(A), -1), d], axis=1), axis=0)
        return Corners(rows[:, :9].reshape(-1, 3, 3), rows[:, 9:], np.full(len(rows), k))

    def _moving(
        self, theta: Floats, k: int, reach: float, raised: NDArray[np.bool_]
    ) -> tuple[Floats, ...]:
        A, d = self._cell(theta, k)
        here = _row(A, d)
        members = self.members(k)
        secants = []
        for number, member in enumerate(members):
            sides = (1, -1) if number < 2 else (-1,)
            found = []
            for side in sides:
                beside = theta.copy()
                beside[member] *= np.exp(side * reach)
                try:
                    found.append((_row(*self._cell(beside, k)) - here) / (side * reach))
                except ModelError:
                    if side < 0:
                        raise
                    raised[member] = False
            secants.append(found)
        rows = np.concatenate([np.concatenate([here, *row], axis=1) for row in product(*secants)])
        size = np.abs(rows).max(axis=0)
        apart = np.round(rows / (SAME * np.where(size > 0, size, 1.0)))
        rows = rows[np.unique(apart, axis=0, return_index=True)[1]]
        count = len(rows)
        parts = rows.reshape(count, 4, 12)
        matrices, vectors = parts[:, :, :9].reshape(count, 4, 3, 3), parts[:, :, 9:]
        return (
            matrices[:, 0],
            vectors[:, 0],
            np.full(count, k),
            np.tile(members, (count, 1)),
            matrices[:, 1:],
            vectors[:, 1:],
        )


def _row(A: Floats, d: Floats) -> Floats:
    return np.concatenate([A.reshape(len(A), -1), d], axis=1)


def _joined(parts: list[Corners]) -> Corners:
    return Corners(
        np.concatenate([part.A for part in parts]),
        np.concatenate([part.d for part in parts]),
        np.concatenate([part.cell for part in parts]),
    )


def _slice(schedule: EffortSchedule, k: int) -> EffortSchedule:
    """Return the schedule of one cell."""
    columns = {
        field.name: getattr(schedule, field.name)[k : k + 2]
        for field in fields(schedule)
        if isinstance(getattr(schedule, field.name), np.ndarray)
    }
    return replace(schedule, **columns)


def _opened(cell: LoopCell) -> LoopCell:
    """Return the cell with each range that is one point a hair wider."""
    wider = {}
    for field in fields(cell):
        value = getattr(cell, field.name)
        if field.name not in NOT_CORNERS and isinstance(value, Interval):
            if value.lower == value.upper:
                wider[field.name] = Interval(value.lower, value.upper + OPENED)
    return replace(cell, **wider)
