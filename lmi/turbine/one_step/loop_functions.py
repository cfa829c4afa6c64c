"""The quadratic functions of the loop at given gains, and the wind error that they tolerate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, largest_scale, slacks
from takagi.lmi.turbine.one_step.loop_of_gains import WindCellCorners
from takagi.models.arrays import Floats


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
    corners: WindCellCorners, rest: WindCellCorners, functions: LoopFunctions, limit: Floats
) -> LoopFunctions | None:
    """Return the functions with multiples and decay rate recomputed at these corners.

    Parameters
    ----------
    functions : P with its set inside the box, and R.  Its multiples and multipliers are kept where
        they hold at the corners and are better than the result of the search over multipliers;
        zeros if there are none.
    limit : (K - 1,) largest multiple for which the corners are valid.

    Returns
    -------
    None if a cell tolerates no wind error.
    """
    found = []
    for k, most in enumerate(limit):
        mine = corners.cell == k
        A, fixed, error = corners.A[mine], corners.fixed[mine], corners.error[mine]
        best = largest_scale(functions.P, A, fixed, error, limit=most)
        scale, alpha = min(functions.scales[k], most), functions.multipliers[k]
        # The search over alpha is one-dimensional and approximate; the step's own alpha may be
        # better.  It counts only if its inequalities hold at the true corners.
        if scale > best[0] and alpha > 0:
            held = slacks(functions.P, A, fixed + scale * error, np.full(len(A), alpha))
            best = (scale, alpha) if held.max() < 0 else best
        found.append(best)
    scales, multipliers = np.array(found).T
    decay = float(decay_rates(functions.R, rest.A).min())
    if scales.min() <= 0:
        return None
    return replace(functions, scales=scales, multipliers=multipliers, decay_rate=decay)
