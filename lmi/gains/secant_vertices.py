"""Secants of a vector function between bounds on its derivatives, as a hull of matrices."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

MOST_ENTRIES = 12


def secant_vertices(low: ArrayLike, high: ArrayLike) -> Floats:
    """Return S_k, (2^v, n, n), whose hull has every S with f(x) - f(y) = S (x - y).

    low_ij <= df_i/dx_j <= high_ij on a convex set with x and y in it.  Row i of S is the gradient
    of f_i somewhere between x and y (mean value theorem), so S lies between low and high, entry
    by entry; the S_k are the combinations of the ends of the v entries that differ.

    Raises
    ------
    ModelError : shapes, entries that are not finite or out of order, more than 12 that differ.
    """
    try:
        ends = [np.asarray(side, dtype=np.float64) for side in (low, high)]
    except (TypeError, ValueError) as error:
        raise ModelError(f"low or high cannot be read as real numbers ({error})") from error
    if ends[0].ndim != 2 or ends[0].shape != ends[1].shape or ends[0].shape[0] != ends[0].shape[1]:
        raise ModelError(
            f"low has shape {ends[0].shape}, high {ends[1].shape}; both must be (n, n)"
        )
    wrong = ~(np.isfinite(ends[0]) & np.isfinite(ends[1]) & (ends[0] <= ends[1]))
    if wrong.any():
        i, j = (int(k) for k in np.argwhere(wrong)[0])
        raise ModelError(
            f"entry [{i}, {j}]: low is {ends[0][i, j]:g}, high is {ends[1][i, j]:g}; finite ends, "
            "the lower one first, are needed"
        )
    varying = np.argwhere(ends[0] < ends[1])
    if len(varying) > MOST_ENTRIES:
        raise ModelError(
            f"{len(varying)} entries vary, which is 2^{len(varying)} vertices; fix the narrow "
            f"ones in the middle, or give fewer vertices yourself; {MOST_ENTRIES} may vary"
        )
    S = np.repeat(ends[0][None], 2 ** len(varying), axis=0)
    for k, corner in enumerate(product((0, 1), repeat=len(varying))):
        for (i, j), end in zip(varying, corner, strict=True):
            S[k, i, j] = ends[end][i, j]
    return S
