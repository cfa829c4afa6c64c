"""The output's variance of one vertex by a Lyapunov equation, with a margin for rounding its P."""

from __future__ import annotations

import numpy as np

from takagi.lmi.cone.balance import state_units
from takagi.models.arrays import Floats

# R weighs each state by its size in P, but with at least this share of the largest size: some
# states hardly appear in the output.
LEAST = 1e-6


def gramian_with_room(
    A: Floats, B: Floats, C: Floats, *, sample_time: float | None, tolerance: float
) -> Floats | None:
    """Return P with He(P A) + C'C < 0, or A' P A - P + C'C < 0, and tr B' P B near the least.

    P solves the equation with C'C + delta R in the place of C'C, R of the size of P in every state,
    and delta so that tr B' P B is ``tolerance`` above the least, relative.

    Parameters
    ----------
    A, B, C : (n, n), (n, q), (p, n) of one vertex.
    sample_time : T in s; None for continuous time.

    Returns
    -------
    P > 0 but for rounding; None where A is not stable, or no such P was found in floating point.
    """
    s = state_units(A[None], None, step=sample_time)
    A, B, C = A * s / s[:, None], B / s[:, None], C * s
    P = _solved(A, C.T @ C, sample_time)
    if P is None:
        return None
    size = np.diag(P)
    more = _solved(A, np.diag(np.maximum(size, LEAST * size.max())), sample_time)
    if more is None:
        return None
    least, added = float(np.sum(B * (P @ B))), float(np.sum(B * (more @ B)))
    if not (least > 0 and added > 0):
        return None
    P = P + tolerance * least / added * more
    # Floats cannot decide whether an ill-conditioned P is definite; the exact check decides later.
    return P / s / s[:, None] if np.isfinite(P).all() and np.diag(P).min() > 0 else None


def _solved(A: Floats, weight: Floats, sample_time: float | None) -> Floats | None:
    """Return P of the Lyapunov equation with -weight on its right; None where A is not stable."""
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    poles = np.linalg.eigvals(A)
    stable = poles.real.max() < 0 if sample_time is None else np.abs(poles).max() < 1
    if not stable:
        return None
    if sample_time is None:
        P = np.asarray(solve_continuous_lyapunov(A.T, -weight), dtype=np.float64)
    else:
        P = np.asarray(solve_discrete_lyapunov(A.T, weight), dtype=np.float64)
    return (P + P.T) / 2
