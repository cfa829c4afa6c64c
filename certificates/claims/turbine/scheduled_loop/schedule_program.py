r"""Functions for cells of the loop about the schedule wind, and the multipliers of given functions.

For a given box, alpha and rate of the wind the claim's inequalities are affine in the functions at
the schedule winds, the multipliers and the weights of the inputs.  ``functions`` solves for all of
these at once, over a range of cells: it looks for functions whose sets are small, by the largest
sum of numbers t, one of each cell, with P >= t h'h for every row h of its box in units of the side.
With t >= 1 the set fits the box; more than ``ENOUGH`` does not count.  For given functions the
inequalities are affine in alpha, too: ``weights`` finds the numbers of one cell that leave most
room for rounding.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from takagi.certificates.claims.turbine.running_loop.cell_program import packed, unit_matrix
from takagi.lmi.cone.assemble import Cone
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats, Indices

# Least eigenvalues that the program asks of the inequalities, in its units.
ROOM = 1e-6
ENOUGH = 1.05
# The least multiplier, in the program's units.
LEAST = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class ScheduleLoop:
    """One cell in units of the solver.

    Attributes
    ----------
    rates, outer : (n, n + 2 + k) and (k, n + 2 + k), over (xi, v'/r, residual, w).
    scale : units of the w.
    rows, limits : (s, n), the rows of the box over their bounds; of ``limits`` the bounds are given
        by limits of the loop, and are kept as they are.
    moved : the bound of |v_s'| [m/s^2].
    """

    rates: Floats
    outer: Floats
    scale: Floats
    rows: Floats
    limits: Floats
    moved: float


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """An end of a cell: P there is (1 - share) P_j + share P_(j+1), ``width`` apart [m/s]."""

    j: int
    share: float
    width: float


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """What ``weights`` found of one cell: alpha, the residual's share, and tau at both ends."""

    decay: float
    residual_share: float
    multipliers: tuple[Floats, Floats]


class SparseProgram:
    """sum x_i parts_i <= constant in each cone, and rows of numbers; entries are kept sparse."""

    def __init__(self) -> None:
        self.variables = 0
        self.entries: list[tuple[Indices, Indices, Floats]] = []
        self.constants: list[Floats] = []
        self.cones: list[Cone] = []
        self.rows = 0
        self.linear: list[tuple[dict[int, float], float]] = []

    def variable(self, count: int = 1) -> int:
        """Return the first of new variables."""
        first = self.variables
        self.variables += count
        return first

    def below(self, parts: Mapping[int, Floats], constant: Floats) -> None:
        """Ask for constant - sum x_i parts_i >= 0, as a matrix."""
        n = len(constant)
        for i, part in parts.items():
            column = packed(part)
            places = np.flatnonzero(column)
            self.entries.append((places + self.rows, np.full(len(places), i), column[places]))
        self.constants.append(packed(constant))
        self.cones.append(Cone(n, 1, self.rows))
        self.rows += n * (n + 1) // 2

    def at_most(self, row: dict[int, float], bound: float) -> None:
        self.linear.append((row, bound))

    def solved(self, objective: Mapping[int, float]) -> Floats | None:
        """Return the least sum of objective_i x_i, or None."""
        count = len(self.linear)
        rows, columns, values = (np.concatenate(part) for part in zip(*self.entries, strict=True))
        extra = [(i, j, x) for i, (row, _) in enumerate(self.linear) for j, x in row.items()]
        rows = np.concatenate([[i for i, _, _ in extra], rows + count])
        columns = np.concatenate([[j for _, j, _ in extra], columns])
        values = np.concatenate([[x for _, _, x in extra], values])
        shape = (count + self.rows, self.variables)
        A = sp.csc_array((values, (rows.astype(int), columns.astype(int))), shape=shape)
        b = np.concatenate([[bound for _, bound in self.linear], *self.constants])
        q = np.zeros(self.variables)
        for i, value in objective.items():
            q[i] = value
        raw = Session().solve(ConeProgram(q, A, b, count, tuple(self.cones)))
        if "Solved" not in raw.status or not np.all(np.isfinite(raw.y)):
            return None
        return np.asarray(raw.y)


def functions(
    loops: Sequence[ScheduleLoop], places: Sequence[tuple[Place, Place]], count: int, decay: float
) -> tuple[float, list[Floats]] | None:
    """Return the least t and the functions at ``count`` winds, or None.

    Parameters
    ----------
    places : the two ends of each cell.
    """
    n = len(loops[0].rates)
    basis = [unit_matrix(n, i, j) for j in range(n) for i in range(j + 1)]
    program = SparseProgram()
    sizes, first = program.variable(len(loops)), program.variable(count * len(basis))
    for t, (loop, ends) in enumerate(zip(loops, places, strict=True), start=sizes):
        program.at_most({t: 1.0}, ENOUGH)
        inputs, k = _inputs(program, decay), len(loop.outer)
        for place in ends:
            tau = _positive(program, k)
            at = [
                (first + (place.j + side) * len(basis), weight, (2 * side - 1) / place.width)
                for side, weight in ((0, 1 - place.share), (1, place.share))
            ]
            function = {
                start + i: -weight * E
                for start, weight, _ in at
                if weight
                for i, E in enumerate(basis)
            }
            for h in loop.rows:
                program.below(function | {t: np.outer(h, h)}, np.zeros((n, n)))
            for h in loop.limits:
                program.below(function, -np.outer(h, h))
            for moved in (loop.moved, -loop.moved):
                parts = _of_numbers(loop, inputs, tau)
                for start, weight, turn in at:
                    for i, E in enumerate(basis):
                        shift = weight * 2 * decay + moved * turn
                        parts[start + i] = _of_function(E, weight * loop.rates, shift)
                program.below(parts, -ROOM * np.eye(n + 2 + k))
    found = program.solved(dict.fromkeys(range(sizes, sizes + len(loops)), -1.0))
    if found is None:
        return None
    return float(found[sizes : sizes + len(loops)].min()), [
        sum(
            (found[first + j * len(basis) + i] * E for i, E in enumerate(basis)),
            np.zeros((n, n)),
        )
        for j in range(count)
    ]


def _inputs(program: SparseProgram, decay: float) -> int:
    """Add the weights of the two inputs, with a sum of 2 alpha at most."""
    first = _positive(program, 2)
    program.at_most({first: 1.0, first + 1: 1.0}, 2 * decay)
    return first


def _positive(program: SparseProgram, count: int) -> int:
    """Add variables that are positive, and return the first."""
    first = program.variable(count)
    for i in range(first, first + count):
        program.at_most({i: -1.0}, -LEAST)
    return first


def _of_function(E: Floats, rates: Floats, shift: float) -> Floats:
    n, size = rates.shape
    found = np.zeros((size, size))
    found[:n] = E @ rates
    found += found.T
    found[:n, :n] += shift * E
    return found


def _of_numbers(loop: ScheduleLoop, inputs: int, tau: int) -> dict[int, Floats]:
    """Return the contributions of the inputs' weights and of the multipliers."""
    n, size = loop.rates.shape
    parts = {inputs + i: -_corner(size, n + i) for i in range(2)}
    for i, z in enumerate(loop.outer):
        parts[tau + i] = np.outer(z, z) - _corner(size, n + 2 + i)
    return parts


def weights(loop: ScheduleLoop, ends: tuple[Floats, Floats], width: float) -> Numbers | None:
    """Return the numbers with which the inequalities hold by the most, or None.

    Parameters
    ----------
    ends : P at the cell's two winds, in units of the solver;  width : of the cell [m/s].
    """
    n, size = loop.rates.shape
    k = len(loop.outer)
    T = np.linalg.inv(np.linalg.cholesky((ends[0] + ends[1]) / 2)).T
    loop, scale = _turned(loop, T)
    ends = T.T @ ends[0] @ T, T.T @ ends[1] @ T
    program = SparseProgram()
    alpha, inputs, least = _positive(program, 1), _positive(program, 2), program.variable()
    program.at_most({inputs: 1.0, inputs + 1: 1.0, alpha: -2.0}, 0.0)
    program.at_most({least: 1.0}, 1.0)
    starts = []
    drift = loop.moved * (ends[1] - ends[0]) / width
    for P in ends:
        starts.append(_positive(program, k))
        for moved in (drift, -drift):
            whole, falling = _of_function(P, loop.rates, 0.0), np.zeros((size, size))
            whole[:n, :n] += moved
            falling[:n, :n] = 2 * P
            parts = _of_numbers(loop, inputs, starts[-1])
            program.below(parts | {alpha: falling, least: np.eye(size)}, -whole)
    found = program.solved({least: -1.0})
    if found is None or found[least] <= 0:
        return None
    used = (
        found[starts[0] : starts[0] + k] / scale**2,
        found[starts[1] : starts[1] + k] / scale**2,
    )
    if min(found[inputs], found[inputs + 1], *used[0], *used[1]) <= 0:
        return None
    total = found[inputs] + found[inputs + 1]
    return Numbers(float(found[alpha]), float(found[inputs + 1] / total), used)


def _turned(loop: ScheduleLoop, T: Floats) -> tuple[ScheduleLoop, Floats]:
    """Return the loop for states T xi, with no z longer than 1, and the units of its w."""
    n, k = len(T), len(loop.outer)
    scale = np.ones(k)
    for i, z in enumerate(loop.outer):
        parts = (z[:n] @ T, z[n : n + 2], z[n + 2 :] * scale)
        scale[i] = max(float(np.linalg.norm(np.concatenate(parts))), 1e-9)
    W = np.eye(n + 2 + k)
    W[:n, :n], W[n + 2 :, n + 2 :] = T, np.diag(scale)
    rates = np.asarray(np.linalg.solve(T, loop.rates @ W), dtype=np.float64)
    return replace(loop, rates=rates, outer=loop.outer @ W / scale[:, None]), scale


def _corner(size: int, place: int) -> Floats:
    found = np.zeros((size, size))
    found[place, place] = 1.0
    return found
