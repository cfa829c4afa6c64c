r"""Whether multipliers rule out every solution, of whatever size: what a no rests on.

A solver's multipliers z bound the margin only for unknowns of about the size that it has seen: what
is left of A' z counts for nothing there, and a margin that is smaller than its tolerances is none.
Where gains are 1e5 times what they act on, solutions are far away and their margins small, and both
go wrong.  A no for all solutions needs z in the cone with

    A' z = 0,    b . z <= 0    for the LMIs b - A x,    a strict one among them, or b . z < 0.

Next to the given multipliers Z_k = L_k L_k' such z is sought as L_k (I + S_k) L_k', |S_k| < 1, with
the least S: a linear system.  It has one in exact arithmetic if it has one here with all that
rounding may add to A' z; and there is none where a solution exists, however small its margin.
Where every such z is singular, only exact arithmetic finds one (``exact_no``).
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.cone.assemble import pack, unpack
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.refutation.multiplier_equalities import Equalities, equalities_of
from takagi.models.arrays import Floats

# Corrections, one after another; how far each may go towards a singular multiplier.
STEPS, FARTHEST = 6, 0.9
# A correction so far beyond is the first of too many.
HOPELESS = 30.0
# How far the next may go, as a multiple: one that grows leads nowhere; the first is that of what
# was added.
NEARER = 1.5
# Of what is summed up in A' z; and how far all of it, with the last correction, may go.
ROUNDING, ROOM = 8.0 * np.finfo(float).eps, 0.5
# What is begun with: the share of the largest multiplier below which a coordinate is left out, and
# what is added to all others, which where b . z is clearly negative costs nothing.
BEGIN = ((0.0, 0.0), (0.0, 1e-8), (0.0, 1e-6), (1e-5, 0.0))
# The least eigenvalue of a multiplier next to 1, which a solver may leave negative.
LEAST = 1e-13


def contradiction(program: ConeProgram, z: Floats) -> Floats | None:
    """Return multipliers that leave no solution at all; None where none are next to z.

    Parameters
    ----------
    program : with the margin as its last variable.
    z : (rows,) in the dual cone, as a solver leaves them.
    """
    if len(z) != len(program.b) or not np.isfinite(z).all() or not z.any():
        return None
    posed: dict[float, Equalities | None] = {}
    for share, added in BEGIN:
        if share not in posed:
            posed[share] = equalities_of(program, z, share)
        equalities = posed[share]
        if equalities is None or (added and not equalities.constant):
            continue
        found = _corrected(equalities, z, added)
        if found is not None:
            return equalities.spread(found, len(z))
    return None


def _corrected(posed: Equalities, given: Floats, added: float) -> Floats | None:
    """Return multipliers next to the given that satisfy the equalities, to rounding."""
    z = given[posed.rows] / np.abs(given[posed.rows]).max()
    before = HOPELESS
    for step in range(STEPS):
        factors = [_factor(z[part], size, 0.0 if step else added) for part, size in posed.parts()]
        z = np.concatenate([pack(L @ L.T) for L in factors])
        left = posed.matrix @ z
        size = abs(posed.matrix) @ np.abs(z)
        if posed.constant:
            # Below zero by what rounding cannot make of zero.
            left[-1] = max(left[-1] + 1e-9 * size[-1], 0.0)
        s, reach = _least(_moved(posed, factors), left, ROUNDING * size)
        if s is None:
            return None
        moves = [unpack(s[part], size)[0] for part, size in posed.parts()]
        farthest = max(float(np.abs(np.linalg.eigvalsh(one)).max()) for one in moves)
        share = 1.0 if farthest < FARTHEST else FARTHEST / farthest
        z = np.concatenate(
            [
                pack(L @ (np.eye(len(one)) + share * one) @ L.T)
                for L, one in zip(factors, moves, strict=True)
            ]
        )
        if farthest + reach < ROOM:
            return z if posed.constant or posed.strict @ z > 0 else None
        if farthest > (before if step != 1 else HOPELESS):
            return None
        before = max(NEARER * farthest, ROOM)
    return None


def _factor(packed: Floats, size: int, added: float) -> Floats:
    """Return L with L L' next to the multiplier, without its negative eigenvalues."""
    values, vectors = np.linalg.eigh(unpack(packed, size)[0])
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0) + max(added, LEAST)))


def _moved(posed: Equalities, factors: list[Floats]) -> Floats:
    """Return the equalities in S of Z = L (I + S) L', (equalities, entries)."""
    found = np.zeros(posed.matrix.shape)
    for (part, _), (used, matrices), L in zip(
        posed.parts(), posed.coefficients, factors, strict=True
    ):
        if len(used):
            found[used, part] = pack(L.T @ matrices @ L)
    return found


def _least(matrix: Floats, left: Floats, noise: Floats) -> tuple[Floats | None, float]:
    """Return the least s with matrix s = -left, and what noise in ``left`` may add to its size."""
    size = np.linalg.norm(matrix, axis=1)
    if not len(size):
        # Nothing depends on any unknown.
        return np.zeros(matrix.shape[1]), 0.0
    if not size.all():
        return None, np.inf
    scaled = matrix / size[:, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    if values[0] <= 1e-14 * len(values) * values[-1]:
        return None, np.inf
    step = -scaled.T @ (vectors @ ((vectors.T @ (left / size)) / values))
    return step, float(np.linalg.norm(noise / size) / np.sqrt(values[0]))
