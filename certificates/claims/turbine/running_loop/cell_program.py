r"""The largest set of one cell, from a semidefinite program in floating point.

In the loop xi' = A xi + B w, z = C xi + D w, w_i^2 <= z_i^2, with Q = P^-1 and S = diag(1/tau),

    [ A Q + Q A' + 2 alpha Q + B S B'    Q C' + B S D' ]
    [ (the same)'                        D S D' - S    ] < 0           for each piece
    h'Q h <= side^2                                                    for each side of the box

are the claim's inequalities after a congruence; they are affine in Q and S.  The objective is the
trace of Q in units of the box, plus a multiple of its least eigenvalue, so that no half width
becomes very small.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.assemble import Cone
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats

# Margins with which the inequalities are posed, so that they hold after rounding: a rate that is
# larger by a twentieth, smaller multipliers and boxes.  Then the factor of the least eigenvalue.
FASTER, MARGIN, LEAST_WEIGHT = 1.05, 1e-3, 2.0
Loop = tuple[Floats, Floats]


def largest_set(
    loops: Sequence[Loop], boxes: Floats, decay: float
) -> tuple[Floats, list[Floats]] | None:
    """Return P and the multipliers of each piece, or None where the solver finds none.

    Parameters
    ----------
    loops : of each piece the rates (n, n + k) and the outer signals (k, n + k), over (xi, w).
    boxes : rows h over their bounds; |h xi| <= 1 is needed.
    """
    n = boxes.shape[1]
    pairs = [(i, j) for j in range(n) for i in range(j + 1)]
    counts = [len(outer) for _, outer in loops]
    starts = np.concatenate([[len(pairs)], len(pairs) + np.cumsum(counts)])
    size = int(starts[-1]) + 1  # Q, the multipliers of each piece, the least eigenvalue
    columns: list[list[Floats]] = [[] for _ in range(size)]
    constants: list[Floats] = []
    basis = [unit_matrix(n, i, j) for i, j in pairs]
    rows = np.zeros((len(boxes), size))
    for place, E in enumerate(basis):
        rows[:, place] = np.einsum("ri,ij,rj->r", boxes, E, boxes)
    cones: list[Cone] = []
    after = 0
    for which, (rates, outer) in enumerate(loops):
        k = counts[which]
        parts = [*by_function(rates, outer, basis, FASTER * decay), *by_multipliers(rates, outer)]
        of = [*range(len(pairs)), *range(starts[which], starts[which] + k)]
        blank = np.zeros((n + k) * (n + k + 1) // 2)
        held = dict(zip(of, parts, strict=True))
        for column in range(size):
            columns[column].append(packed(held[column]) if column in held else blank)
        constants.append(np.zeros(len(blank)))
        cones.append(Cone(n + k, 1, after))
        after += (n + k) * (n + k + 1) // 2
    # Q - q I >= 0.
    for column in range(size):
        if column < len(pairs):
            columns[column].append(-packed(basis[column]))
        else:
            columns[column].append(packed(np.eye(n)) * float(column == size - 1))
    constants.append(np.zeros(n * (n + 1) // 2))
    cones.append(Cone(n, 1, after))
    A = np.vstack([rows, np.column_stack([np.concatenate(column) for column in columns])])
    b = np.concatenate([np.full(len(boxes), 1 - MARGIN), *constants])
    q = -np.array([float(i == j) for i, j in pairs] + [0.0] * (size - len(pairs)))
    q[-1] = -LEAST_WEIGHT * n
    raw = Session().solve(ConeProgram(q, sp.csc_array(A), b, len(boxes), tuple(cones)))
    if "Solved" not in raw.status or not np.all(np.isfinite(raw.y)):
        return None
    Q = sum((raw.y[p] * E for p, E in enumerate(basis)), np.zeros((n, n)))
    S = [raw.y[a:b] for a, b in zip(starts[:-1], starts[1:], strict=True)]
    if np.linalg.eigvalsh(Q).min() <= 0 or min(float(s.min(initial=1)) for s in S) <= 0:
        return None
    return np.linalg.inv(Q), [1 / s for s in S]


def by_function(
    rates: Floats, outer: Floats, basis: list[Floats], decay: float
) -> Iterator[Floats]:
    """Yield the contribution of each entry of Q to the inequality of one piece."""
    n = len(rates)
    A, C = rates[:, :n], outer[:, :n]
    for E in basis:
        AQ, QC = A @ E, E @ C.T
        yield np.block([[AQ + AQ.T + 2 * decay * E, QC], [QC.T, np.zeros((len(C), len(C)))]])


def by_multipliers(rates: Floats, outer: Floats) -> Iterator[Floats]:
    """Yield the contribution of each 1/tau to the same inequality."""
    n, k = len(rates), len(outer)
    along = np.vstack([rates[:, -k:], outer[:, -k:]]) if k else np.zeros((n, 0))
    for i in range(k):
        found = np.outer(along[:, i], along[:, i])
        found[n + i, n + i] -= 1 - MARGIN
        yield found


def unit_matrix(n: int, i: int, j: int) -> Floats:
    """Return the symmetric matrix with ones at (i, j) and (j, i)."""
    found = np.zeros((n, n))
    found[i, j] = found[j, i] = 1.0
    return found


def packed(matrix: Floats) -> Floats:
    """Return the upper triangle by columns, off-diagonal entries times sqrt(2)."""
    n = len(matrix)
    columns, rows = np.tril_indices(n)
    factor = np.where(rows == columns, 1.0, np.sqrt(2.0))
    return np.asarray(matrix[rows, columns] * factor)
