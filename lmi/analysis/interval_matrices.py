r"""Quadratic functions for interval families of matrices, without listing their corners.

For A = M + D with |D_ij| <= R_ij and any weights w_ij > 0,

    P D + D' P <= E = sum_ij R_ij (w_ij P e_i e_i' P + e_j e_j' / w_ij),

since each entry gives 2 R |a b| <= R (w a^2 + b^2 / w); taken here: w_ij = 1/sqrt(P_ii), which is
right where the set touches |x_j| <= 1.  So with N = -(M'P + PM) - E

    N - 2 rho P > 0                               V = x'Px decays at 2 rho for every A,
    [[N - alpha P, -P d], [-d'P, alpha]] > 0      {V <= 1} is invariant under x' = A x + d,
                                                  at the corners of |d_i| <= delta_i.

One inequality for 2^n^2 corners; the weights are free, so that rounding them costs nothing but
room.  Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.1 and 6.1.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from takagi.models.arrays import Floats

MULTIPLIERS = (0.3, 0.6, 0.9, 0.1)
SHIFTS = (0.0, 0.5, 0.85)
# A proof in floats needs a margin: this share of alpha is kept in reserve.
ROOM = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Contraction:
    """What one P shows of a family: decay rate rho and multiplier alpha [1/s]."""

    decay_rate: float
    multiplier: float


def contraction(P: Floats, low: Floats, high: Floats, disturbance: Floats) -> Contraction | None:
    """Return rate and multiplier for which {x'Px <= 1} is invariant, or None.

    Parameters
    ----------
    low, high : (corners, n, n), the ranges of each corner of the family.
    disturbance : (n,) delta.
    """
    lower = np.linalg.cholesky(P)
    inverse = np.linalg.inv(lower)
    middle, radius = (low + high) / 2, (high - low) / 2
    decreases = [_spare(P, m, r) for m, r in zip(middle, radius, strict=True)]
    rate = min(float(np.linalg.eigvalsh(inverse @ N @ inverse.T)[0]) for N in decreases) / 2
    if rate <= 0:
        return None
    signs = np.array(
        [(1.0, *signs_behind) for signs_behind in product((1.0, -1.0), repeat=len(P) - 1)]
    )
    push = (signs * disturbance) @ P
    for share in MULTIPLIERS:
        alpha = 2 * rate * share
        if all(_invariant(N - alpha * P, push, alpha) for N in decreases):
            return Contraction(rate, alpha)
    return None


def lyapunov_candidates(corners: Floats) -> list[Floats]:
    """Return P from Lyapunov equations of the mean of the corners, for several weights.

    Parameters
    ----------
    corners : (corners, n, n).
    """
    from scipy.linalg import solve_continuous_lyapunov

    mean = corners.mean(axis=0)
    slowest = -float(np.linalg.eigvals(mean).real.max())
    if slowest <= 0:
        return []
    eye = np.eye(len(mean))
    candidates = [solve_continuous_lyapunov((mean + s * slowest * eye).T, -eye) for s in SHIFTS]
    modes = np.linalg.inv(np.linalg.eig(mean)[1])
    candidates.append((modes.conj().T @ modes).real)
    return [(P + P.T) / 2 for P in candidates if np.all(np.linalg.eigvalsh(P + P.T) > 0)]


def _spare(P: Floats, middle: Floats, radius: Floats) -> Floats:
    """Return N."""
    PM = P @ middle
    weights = 1 / np.sqrt(np.diag(P))[:, None]
    rows = (radius * weights).sum(axis=1)
    columns = (radius / weights).sum(axis=0)
    return np.asarray(-(PM + PM.T) - (P * rows) @ P - np.diag(columns))


def _invariant(decrease: Floats, push: Floats, alpha: float) -> bool:
    if np.linalg.eigvalsh(decrease)[0] <= 0:
        return False
    demanded = (push * np.linalg.solve(decrease, push.T).T).sum(axis=1)
    return bool(demanded.max() < alpha * (1 - ROOM))
