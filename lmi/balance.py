"""Coordinates in which the numbers are of order one: powers of two, so nothing is rounded."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.intake import positive_vector
from takagi.lmi.term import Array

__all__ = ["balanced_inputs", "balanced_states", "nearest_power", "state_units"]


def nearest_power(values: Array) -> Array:
    """Return the nearest power of two to each positive value."""
    return np.asarray(np.exp2(np.round(np.log2(values))))


def balanced_states(A: Array) -> Array:
    """Return s, (n,), powers of two, so that S^-1 A_i S has rows and columns of like size.

    S = diag(s); x = S xhat.  One s for all vertices, from the sum of their absolute values.
    Balancing removes units (rad against N m) without touching a single significant digit.

    Source: Parlett and Reinsch (1969), Balancing a matrix, Numer. Math. 13.
    """
    from scipy.linalg import matrix_balance

    mean = np.abs(A.astype(np.float64)).mean(axis=0)
    _, (scale, _) = matrix_balance(mean, permute=False, separate=True)
    scale = np.asarray(scale, dtype=np.float64)
    return nearest_power(scale / np.exp(np.mean(np.log(scale))))


def balanced_inputs(B: Array, size: float) -> Array:
    """Return s, (m,), powers of two, so that the largest |B_i s_k| of input k is about size."""
    largest = np.abs(B.astype(np.float64)).max(axis=(0, 1))
    return nearest_power(size / largest)


def state_units(A: Array, scales: ArrayLike | None) -> Array:
    """Return s, (n,): the powers of two next to the given scales, or those that balance A.

    Raises
    ------
    ModelError : scales of another length, or not positive.
    """
    if scales is None:
        return balanced_states(A)
    return nearest_power(positive_vector("scales", scales, A.shape[1]))
