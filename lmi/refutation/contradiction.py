r"""Multipliers that prove that a set of LMIs has no solution of any size.

A solver returns approximate multipliers z.  They bound the margin only for unknowns of moderate
size, for two reasons: the solver neglects the residual A' z, which large unknowns amplify, and it
treats a margin below its tolerance as zero.  If gains are 1e5 times the states that they multiply,
solutions are large and their margins are small, and both approximations fail.  The LMIs b - A x
have no solution of any size if some z in the dual cone satisfies

    A' z = 0    and    b . z < 0,    or b . z = 0 and z is nonzero at a strict LMI.

The search starts from the given multipliers Z_k = L_k L_k'.  It takes L_k (I + S_k) L_k' with
|S_k| < 1, which stays in the cone, and computes the smallest S with A' z = 0 from a linear system.
The result allows for the rounding errors of A' z: if the system has a solution here, it has one in
exact arithmetic.  If the LMIs have a solution, no such z exists, even when the margin is small.  If
every such z is singular, only exact arithmetic finds one (``exact_no``).
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.cone.assemble import pack, unpack
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.refutation.multiplier_equalities import Equalities, equalities_of
from takagi.models.arrays import Floats

# The number of corrections, and the largest |S| of one correction.  At |S| = 1 the multiplier
# I + S may become singular and leave the cone.
STEPS, FARTHEST = 6, 0.9
# If one of the first two corrections asks for a larger |S| than this, the search ends without a
# result: the corrections do not converge.
HOPELESS = 30.0
# Later, |S| may be at most this multiple of the last one; a larger one means divergence.  The first
# one is no measure, because it also removes what ``BEGIN`` added.
NEARER = 1.5
# The rounding error of A' z, relative to the sum of the absolute values of its terms; and the
# largest |S| of the last correction with the effect of that error included.
ROUNDING, ROOM = 8.0 * np.finfo(float).eps, 0.5
# Pairs that are tried in this order.  First: a coordinate is left out if it is below this share of
# the largest multiplier.  Second: a number that is added to the other eigenvalues, to move the
# multipliers away from the boundary of the cone.  The addition is harmless if b . z is clearly
# negative, and is tried only then.
BEGIN = ((0.0, 0.0), (0.0, 1e-8), (0.0, 1e-6), (1e-5, 0.0))
# Eigenvalues are raised by at least this, relative to the largest entry: a solver may leave small
# negative ones.
LEAST = 1e-13


def contradiction(program: ConeProgram, z: Floats) -> Floats | None:
    """Return multipliers that exclude every solution; None if none are found near z.

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
    """Return multipliers near the given ones that satisfy the equalities up to rounding."""
    z = given[posed.rows] / np.abs(given[posed.rows]).max()
    before = HOPELESS
    for step in range(STEPS):
        factors = [_factor(z[part], size, 0.0 if step else added) for part, size in posed.parts()]
        z = np.concatenate([pack(L @ L.T) for L in factors])
        left = posed.matrix @ z
        size = abs(posed.matrix) @ np.abs(z)
        if posed.constant:
            # The last row is b . z.  Only its positive part is corrected; the term 1e-9 keeps it
            # below zero by more than rounding can add.
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
    """Return L with L L' close to the multiplier; negative eigenvalues become zero first."""
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
    """Return the smallest s with matrix s = -left, and a bound on what noise in ``left`` adds."""
    size = np.linalg.norm(matrix, axis=1)
    if not len(size):
        # There are no equalities, because no LMI depends on an unknown.
        return np.zeros(matrix.shape[1]), 0.0
    if not size.all():
        return None, np.inf
    scaled = matrix / size[:, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    # Equalities that depend on each other up to rounding have no well-defined solution in floats.
    if values[0] <= 1e-14 * len(values) * values[-1]:
        return None, np.inf
    step = -scaled.T @ (vectors @ ((vectors.T @ (left / size)) / values))
    return step, float(np.linalg.norm(noise / size) / np.sqrt(values[0]))
