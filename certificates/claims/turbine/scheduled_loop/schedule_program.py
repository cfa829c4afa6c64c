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

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from takagi.certificates.claims.turbine.running_loop.cell_program import unit_matrix
from takagi.certificates.claims.turbine.running_loop.sparse_program import (
    SparseProgram,
    of_function,
    of_numbers,
)
from takagi.models.arrays import Floats

# Least eigenvalues that the program asks of the inequalities, in its units.
ROOM = 1e-6
ENOUGH = 1.05


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
        inputs, k = program.inputs(decay), len(loop.outer)
        for place in ends:
            tau = program.positive(k)
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
                parts = of_numbers(loop.outer, inputs, tau)
                for start, weight, turn in at:
                    for i, E in enumerate(basis):
                        shift = weight * 2 * decay + moved * turn
                        parts[start + i] = of_function(E, weight * loop.rates, shift)
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
    alpha, inputs, least = program.positive(1), program.positive(2), program.variable()
    program.at_most({inputs: 1.0, inputs + 1: 1.0, alpha: -2.0}, 0.0)
    program.at_most({least: 1.0}, 1.0)
    starts = []
    drift = loop.moved * (ends[1] - ends[0]) / width
    for P in ends:
        starts.append(program.positive(k))
        for moved in (drift, -drift):
            whole, falling = of_function(P, loop.rates, 0.0), np.zeros((size, size))
            whole[:n, :n] += moved
            falling[:n, :n] = 2 * P
            parts = of_numbers(loop.outer, inputs, starts[-1])
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
