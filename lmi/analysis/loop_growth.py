r"""Families of matrices that grow with the box: base + s direction, s from the nominal point.

The vertices of the enlarged box are A_i(theta) = A_0 + theta (A_i - A_0), B_i(theta) likewise,
with the nominal A_0 = sum_i h0_i A_i.  Where A is affine in the premises, as of every sector
model, these are the vertices over the premises' ranges stretched by theta about the nominal point.

Which matrices a law u = -K x adds depends on how its gains follow the enlarged plant:

independent  K is any blend of the K_j whatever the plant does, so all A_i(theta) - B_i(theta) K_j;
             they grow from theta = 0
stretched    K = sum_j h_j K_j with the h of the enlarged box, so the means of the pairs (i, j);
             they grow from theta = 1, where the law works in its own box
clamped      K is scheduled over its own box, and at its edge beyond: inside, the means of the
             pairs at theta = 1; beyond, those premises in which i and j take the same corner may
             be stretched, each by itself, while K stays
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.loop_pairs import gain_stack, pairs_of
from takagi.lmi.argument_checks import Vertices, corners_of, input_stack, vertex_stack
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean

Law: TypeAlias = Literal["independent", "stretched", "clamped"]
LAWS: tuple[Law, ...] = get_args(Law)
# Of the largest entry: how far the vertices of "clamped" may be from affine in the premises.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class EnlargedLoops:
    """Matrices base_k + s direction_k, s = theta - begin.

    Attributes
    ----------
    base, direction : (N, n, n).
    nominal : (b, n, n), among whose blends all of base are.
    begin : the enlargement theta at s = 0.
    labels : one a matrix.
    """

    base: Floats
    direction: Floats
    nominal: Floats
    begin: float
    labels: tuple[str, ...]

    def scaled(self, s: Floats) -> EnlargedLoops:
        """Return the family in states x / s."""
        base, direction, nominal = (
            part * s / s[:, None] for part in (self.base, self.direction, self.nominal)
        )
        return EnlargedLoops(base, direction, nominal, self.begin, self.labels)

    def of(self, chosen: np.ndarray[tuple[int], np.dtype[np.intp]]) -> EnlargedLoops:
        """Return some of the matrices."""
        labels = tuple(self.labels[k] for k in chosen)
        return EnlargedLoops(
            self.base[chosen], self.direction[chosen], self.nominal, self.begin, labels
        )


def enlarged_loops(
    model: Vertices,
    *,
    gains: ArrayLike | None = None,
    law: Law = "independent",
    nominal: ArrayLike | None = None,
) -> EnlargedLoops:
    """Return the matrices of the module's formulas; without gains those of A alone.

    Raises
    ------
    ModelError : shapes, an unknown law, a nominal point that is none, or a model that is not
        affine in its premises for "clamped".
    """
    if law not in LAWS:
        raise ModelError(
            f"law {law!r} is not known; there are {', '.join(LAWS)}" + did_you_mean(str(law), LAWS)
        )
    A = vertex_stack(model).astype(np.float64)
    h0 = _nominal(nominal, len(A))
    if gains is None:
        if law == "clamped":
            raise ModelError('law "clamped" is about gains; give gains, or leave law out')
        return _vertices(A, h0)
    B = input_stack(model, A).astype(np.float64)
    K = gain_stack(gains, len(B), B.shape[2], A.shape[2])
    A0, B0 = np.tensordot(h0, A, axes=1), np.tensordot(h0, B, axes=1)
    if law == "independent":
        return _independent(A0, B0, A - A0, B - B0, K)
    if law == "stretched":
        return _stretched(A, B, A - A0, B - B0, K)
    return _clamped(model, A, B, h0, K)


def _nominal(nominal: ArrayLike | None, count: int) -> Floats:
    """Return the memberships of the nominal point, (r,)."""
    if nominal is None:
        return np.full(count, 1.0 / count)
    try:
        h0 = np.asarray(nominal, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"nominal cannot be read as numbers ({error})") from error
    if h0.shape != (count,) or not np.isfinite(h0).all():
        raise ModelError(
            f"nominal has shape {h0.shape}; memberships ({count},), all finite, are needed: one "
            "for each vertex, e.g. model.memberships(z0)"
        )
    if h0.min() < 0 or abs(h0.sum() - 1) > 1e-9:
        raise ModelError(
            f"nominal has the least entry {h0.min():g} and the sum {h0.sum():g}; memberships are "
            "not negative and sum to 1"
        )
    return np.asarray(h0 / h0.sum())


def _vertices(A: Floats, h0: Floats) -> EnlargedLoops:
    A0 = np.tensordot(h0, A, axes=1)
    labels = tuple(f"vertex {k + 1} of {len(A)}" for k in range(len(A)))
    return EnlargedLoops(np.broadcast_to(A0, A.shape), A - A0, A0[None], 0.0, labels)


def _independent(A0: Floats, B0: Floats, dA: Floats, dB: Floats, K: Floats) -> EnlargedLoops:
    different, of = np.unique(K, axis=0, return_inverse=True)
    r, g = len(dA), len(different)
    nominal = A0 - B0 @ different
    i, j = np.divmod(np.arange(r * g), g)
    first = [int(np.argmax(of.ravel() == k)) + 1 for k in range(g)]
    labels = tuple(f"vertex {a + 1}, gain {first[b]}" for a, b in zip(i, j, strict=True))
    return EnlargedLoops(nominal[j], dA[i] - dB[i] @ different[j], nominal, 0.0, labels)


def _stretched(A: Floats, B: Floats, dA: Floats, dB: Floats, K: Floats) -> EnlargedLoops:
    i, j = np.triu_indices(len(A))
    base = pairs_of(A, B, K)
    labels = tuple(_pair(a, b) for a, b in zip(i.tolist(), j.tolist(), strict=True))
    return EnlargedLoops(base, pairs_of(dA, dB, K), np.unique(base, axis=0), 1.0, labels)


def _clamped(model: Vertices, A: Floats, B: Floats, h0: Floats, K: Floats) -> EnlargedLoops:
    corners = corners_of(model)
    if corners is None:
        raise ModelError(
            'law "clamped" needs to know which corners the rules take; give a model with '
            'premises, or take law "independent", which covers it'
        )
    parts = _parts(np.concatenate([A, B], axis=2), corners, h0)
    acting = parts.any(axis=(1, 2, 3))
    n = A.shape[1]
    base, direction, labels = [], [], []
    for i, j in zip(*np.triu_indices(len(A)), strict=True):
        mean = (A[i] + A[j] - B[i] @ K[j] - B[j] @ K[i]) / 2
        same = np.flatnonzero((corners[i] == corners[j]) & acting)
        for kept in product((False, True), repeat=len(same)):
            moved = same[np.array(kept, dtype=bool)]
            grown = parts[moved, corners[i, moved]].sum(axis=0)
            base.append(mean)
            direction.append(grown[:, :n] - grown[:, n:] @ (K[i] + K[j]) / 2)
            labels.append(_pair(int(i), int(j)) + _beyond(model, moved))
    family = np.array(base)
    return EnlargedLoops(family, np.array(direction), np.unique(family, axis=0), 1.0, tuple(labels))


def _parts(
    M: Floats, corners: np.ndarray[tuple[int, int], np.dtype[np.intp]], h0: Floats
) -> Floats:
    """Return V, (premises, 2, ., .): M_i = M_0 + sum_k V[k, c_ik], M_0 at the nominal point.

    Raises
    ------
    ModelError : the vertices are not affine in the premises.
    """
    design = np.concatenate([np.ones((len(M), 1)), corners], axis=1)
    slopes = np.linalg.lstsq(design, M.reshape(len(M), -1), rcond=None)[0]
    gap = float(np.abs(design @ slopes - M.reshape(len(M), -1)).max())
    if gap > ROUNDING * np.abs(M).max():
        raise ModelError(
            f"the vertices are up to {gap:.3g} away from matrices affine in the premises, so what "
            'a premise beyond its range does is not known; take law "independent"'
        )
    share = h0 @ corners
    E = slopes[1:].reshape(-1, *M.shape[1:])
    return np.stack([-share[:, None, None] * E, (1 - share)[:, None, None] * E], axis=1)


def _pair(i: int, j: int) -> str:
    return f"rule {i + 1}" if i == j else f"rules {i + 1} and {j + 1}"


def _beyond(model: Vertices, moved: np.ndarray[tuple[int], np.dtype[np.intp]]) -> str:
    if not len(moved):
        return ""
    names = [premise.name for premise in getattr(model, "premises", ())]
    return ", beyond the box in " + ", ".join(names[k] for k in moved)
