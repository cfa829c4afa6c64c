"""The loop of given gains at pairs of rules: u = -sum_j h_j K_j x."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.condition.term import Array
from takagi.models.errors import ModelError
from takagi.models.ts.vertex_arrays import finite_array


def gain_stack(gains: ArrayLike, r: int, m: int, n: int) -> Array:
    """Return K, (r, m, n), of u = -sum_j h_j K_j x; one (m, n) gain stands for all rules.

    Raises
    ------
    ModelError : another shape, or an entry that is not finite.
    """
    K = finite_array("K", gains)
    if K.shape not in ((r, m, n), (1, m, n), (m, n)):
        raise ModelError(
            f"gains have shape {K.shape}; ({r}, {m}, {n}) is needed, or ({m}, {n}) for the same "
            "gain in every rule"
        )
    return np.broadcast_to(K, (r, m, n))


def pairs_of(X: Array, Y: Array, K: Array) -> Array:
    """Return (X_i - Y_i K_j + X_j - Y_j K_i) / 2 for i <= j, (r (r + 1) / 2, ., .).

    sum_ij h_i h_j (X_i - Y_i K_j) is a blend of these, with weights h_i^2 and 2 h_i h_j.

    ``X``, ``Y``, ``K`` : (r, p, n), (r, p, m), (r, m, n).
    """
    i, j = np.triu_indices(len(X))
    return np.asarray((X[i] - Y[i] @ K[j] + X[j] - Y[j] @ K[i]) / 2)


def of_pairs(answer: Answer, gains: ArrayLike | None) -> Answer:
    """Return a "no" whose vertices are rules and means of pairs, with what it proves."""
    if answer.found or gains is None or not answer.diagnosis:
        return answer
    words = "the vertices are rules and means of pairs of rules; a mean that fails excludes nothing"
    return replace(answer, diagnosis=f"{answer.diagnosis} ({words})")
