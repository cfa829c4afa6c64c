"""Exact decisions whether a symmetric matrix is positive definite or semidefinite, by integers."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.models.arrays import Indices

# The first test keeps only so many leading bits of the entries, which is fast.  It succeeds unless
# the matrix is singular to that accuracy.
SHORT = 96


def is_semidefinite(matrix: Array) -> bool:
    """Return whether x' M x >= 0 for all x; M is (n, n), symmetric, of Fractions or ints.

    Both answers are exact.
    """
    integers = _integers(matrix)
    if _clearly_definite(integers):
        return True
    # M is semidefinite if its restriction to a complement of its null space is.  The kept
    # coordinates span such a complement.
    kept = _without_null(integers)
    inside = integers[np.ix_(kept, kept)]
    return _clearly_definite(inside) or _pivots_hold(inside, zero=True)


def is_definite(matrix: Array) -> bool:
    """Return whether x' M x > 0 for all x other than 0; both answers are exact."""
    integers = _integers(matrix)
    return _clearly_definite(integers) or _pivots_hold(integers, zero=False)


def _clearly_definite(integers: Array) -> bool:
    """Return True if the leading bits of the entries prove definiteness; False decides nothing.

    After the shift the omitted part is a symmetric matrix with entries in [0, 1).  Its norm is at
    most n, so the truncated matrix minus n I is a lower bound of the shifted matrix.
    """
    n = len(integers)
    bits = max((abs(entry).bit_length() for entry in integers.flat), default=0)
    if bits <= SHORT:
        return _pivots_hold(integers, zero=False)
    cut = np.right_shift(integers, bits - SHORT) - n * np.eye(n, dtype=object)
    return _pivots_hold(cut, zero=False)


def _without_null(integers: Array) -> Indices:
    """Return coordinates whose span contains no null vector but 0; there are rank(M) of them."""
    import flint

    n = len(integers)
    vectors, count = flint.fmpz_mat(integers.tolist()).nullspace()
    if not count:
        return np.arange(n)
    rows = [[vectors[i, k] for i in range(n)] for k in range(count)]
    reduced, _, rank = flint.fmpz_mat(rows).rref()
    pivots = [next(i for i in range(n) if reduced[k, i] != 0) for k in range(rank)]
    return np.setdiff1d(np.arange(n), pivots)


def _integers(matrix: Array) -> Array:
    exact = [Fraction(entry) for entry in matrix.flat]
    denominator = math.lcm(*(entry.denominator for entry in exact))
    integers = np.empty(len(exact), dtype=object)
    integers[:] = [entry.numerator * (denominator // entry.denominator) for entry in exact]
    return integers.reshape(matrix.shape)


def _pivots_hold(integers: Array, *, zero: bool) -> bool:
    """Return whether all pivots are positive; ``zero`` also allows zero pivots in zero rows.

    The elimination is fraction-free: all divisions are exact.

    Source: Bareiss (1968), Sylvester's identity and multistep integer-preserving Gaussian
    elimination, Mathematics of Computation 22.
    """
    M, previous = integers.copy(), 1
    for k in range(len(M)):
        pivot = M[k, k]
        if pivot < 0 or (pivot == 0 and (not zero or any(M[k, k + 1 :]))):
            return False
        if pivot == 0:
            continue
        rest = M[k + 1 :, k + 1 :] * pivot - np.outer(M[k + 1 :, k], M[k, k + 1 :])
        M[k + 1 :, k + 1 :] = rest // previous
        previous = pivot
    return True
