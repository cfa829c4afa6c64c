r"""A norm-bounded block around given matrices: X = D Theta [E, F] with |Theta| <= 1, exactly.

With D and W = [E, F] of full rank on the rows and columns in which the X_i differ from zero,
Theta_i = D^-1 X_i W^-1 is rational, and so is the square of its Frobenius norm.  D and W are turned
along the singular vectors of all X_i, so that differences along one direction cost one direction,
and weighed so that units do not matter; both are only a choice, the norm is what is proved.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import exact
from takagi.models.reduction.exact_residual import root_above

Rationals: TypeAlias = NDArray[Any]

# Directions of less weight than this share of the first have this weight: it costs nothing, and
# D and W stay far from singular.
LEAST_WEIGHT = 1e-6
BALANCE_ROUNDS = 20
# A margin for the rounding of the floats in D.
ROOM = 1e-9


class NormBlock(NamedTuple):
    """[A B] + D Delta [E, F] with |Delta| <= 1: what ``takagi.lmi.NormBounded(*block)`` takes.

    D (n, p), E (q, n), F (q, m).
    """

    D: Floats
    E: Floats
    F: Floats


def block_around(matrices: Rationals, n: int) -> tuple[NormBlock, ...]:
    """Return one block that has every convex sum of the matrices; none where all are zero.

    Proved for the floats of D, E and F read either way, as binary numbers and as the shortest
    decimals that print them.

    Parameters
    ----------
    matrices : (k, n, n + m) of Fractions; at least one is not zero, or nothing is returned.
    n : number of states.
    """
    approximate = matrices.astype(np.float64)
    if not len(matrices) or not any(entry != 0 for entry in matrices.flat):
        return ()
    # An entry below the smallest float still is an entry.
    nonzero = np.vectorize(lambda entry: entry != 0, otypes=[bool])(matrices).any(axis=0)
    rows, columns = np.flatnonzero(nonzero.any(axis=1)), np.flatnonzero(nonzero.any(axis=0))
    part = matrices[:, rows][:, :, columns]
    enters, driven = _directions(approximate[:, rows][:, :, columns])
    size = max(_norm(part, reading(enters), reading(driven)) for reading in READINGS)
    scale = float(size)
    while True:
        scale *= 1 + ROOM
        D = enters * scale
        if all(_norm(part, reading(D), reading(driven)) <= 1 for reading in READINGS):
            break
    whole, picked = np.zeros((n, len(rows))), np.zeros((len(columns), matrices.shape[2]))
    whole[rows], picked[:, columns] = D, driven
    return (NormBlock(whole, picked[:, :n], picked[:, n:]),)


def entry_blocks(matrices: Rationals, n: int) -> tuple[NormBlock, ...]:
    """Return a block for each entry that is not always zero, at least as large as any of them.

    Each block has a number as its Delta; together they allow entries to move independently.
    """
    blocks = []
    for row, column in np.ndindex(matrices.shape[1:]):
        largest = max((abs(entry) for entry in matrices[:, row, column]), default=Fraction(0))
        if largest == 0:
            continue
        D, driven = np.zeros((n, 1)), np.zeros((1, matrices.shape[2]))
        D[row, 0], driven[0, column] = _float_above(largest), 1.0
        blocks.append(NormBlock(D, driven[:, :n], driven[:, n:]))
    return tuple(blocks)


def _directions(X: Floats) -> tuple[Floats, Floats]:
    """Return square D and W in floats, along what the matrices have in common."""
    tall, wide = _balance(np.sqrt((X**2).sum(axis=0)))
    balanced = X / tall[:, None] / wide
    left, first, _ = np.linalg.svd(np.hstack(list(balanced)), full_matrices=True)
    _, second, right = np.linalg.svd(np.vstack(list(balanced)), full_matrices=True)
    D = tall[:, None] * left * _weights(first, len(tall))
    return D, _weights(second, len(wide))[:, None] * right * wide


def _balance(sizes: Floats) -> tuple[Floats, Floats]:
    """Return weights that make rows and columns of sizes / (rows columns') equally large."""
    rows, columns = np.ones(len(sizes)), np.ones(sizes.shape[1])
    tiny = np.finfo(np.float64).tiny
    for _ in range(BALANCE_ROUNDS):
        rows *= np.sqrt(np.maximum((sizes / rows[:, None] / columns).max(axis=1), tiny))
        columns *= np.sqrt(np.maximum((sizes / rows[:, None] / columns).max(axis=0), tiny))
    # Powers of two, within a range in which products of two do not overflow.
    return tuple(np.exp2(np.round(np.clip(np.log2(w), -200, 200))) for w in (rows, columns))  # type: ignore[return-value]


def _weights(singular: Floats, size: int) -> Floats:
    """Return the square roots of the singular values as shares of the first, none below 1e-6."""
    found = np.zeros(size)
    found[: len(singular)] = np.sqrt(singular / singular[0]) if singular[0] > 0 else 0.0
    return np.maximum(found, LEAST_WEIGHT)


def _norm(X: Rationals, D: Rationals, W: Rationals) -> Fraction:
    """Return max_i of the Frobenius norm of D^-1 X_i W^-1, rounded up."""
    # Integers over one denominator each: many times faster than Fractions.
    (before, below), (inside, under), (after, beneath) = (
        _integers(matrix) for matrix in (_inverse(D), X, _inverse(W))
    )
    largest = max(int(sum((before @ x @ after).ravel() ** 2)) for x in inside)
    return root_above(Fraction(largest, (below * under * beneath) ** 2))


def _integers(matrix: Rationals) -> tuple[Rationals, int]:
    common = lcm(*{entry.denominator for entry in matrix.flat})
    found = np.empty(matrix.shape, dtype=object)
    for index, entry in np.ndenumerate(matrix):
        found[index] = entry.numerator * (common // entry.denominator)
    return found, common


def _inverse(matrix: Rationals) -> Rationals:
    """Return the inverse over the rationals by Gauss-Jordan elimination, largest pivots first."""
    n = len(matrix)
    one = np.array([[Fraction(i == j) for j in range(n)] for i in range(n)], dtype=object)
    both = np.hstack((matrix, one))
    for k in range(n):
        pivot = k + max(range(n - k), key=lambda i: abs(both[k + i, k]))
        both[[k, pivot]] = both[[pivot, k]]
        both[k] = both[k] / both[k, k]
        for i in range(n):
            if i != k and both[i, k] != 0:
                both[i] = both[i] - both[i, k] * both[k]
    return both[:, n:]


def _binary(array: Floats) -> Rationals:
    return _read(array, Fraction)


def _decimal(array: Floats) -> Rationals:
    return _read(array, exact)


def _read(array: Floats, reading: Any) -> Rationals:
    found = np.empty(array.shape, dtype=object)
    for index, value in np.ndenumerate(array):
        found[index] = reading(float(value))
    return found


READINGS = (_binary, _decimal)


def _float_above(value: Fraction) -> float:
    """Return a float at least the value, as a binary number and as the decimal that prints it."""
    found = float(value)
    while Fraction(found) < value or exact(found) < value:
        found = float(np.nextafter(found, np.inf))
    return found
