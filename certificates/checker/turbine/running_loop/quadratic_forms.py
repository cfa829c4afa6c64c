r"""What is asked of a quadratic form with long entries: whether it is definite, and its extent.

Definiteness is decided of a rounded matrix with short entries.  With D = diag(2^-e_i), entries of
D M D are rounded down to integers: D M D = R + E, E symmetric with entries from 0 to 1, so its
eigenvalues are at most n in size.  If R - n I > 0 then M > 0.  The e_i make the diagonal of D M D
about 2^BITS, so that n is negligible.

The extent of an ellipsoid along several rows is exact, by one elimination for all rows.
Source: Bareiss (1968), Math. Comp. 22, fraction-free elimination: every number is a minor of the
matrix [P, h'; h, 0], and h P^-1 h' is less the ratio of the last two.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from takagi.certificates.checker.kernel.definite import (
    is_symmetric,
    positive_definite_integers,
    to_integers,
)

Row = Sequence[Fraction]
BITS = 64


def is_surely_definite(matrix: Sequence[Sequence[int]]) -> bool:
    """Return whether a symmetric integer matrix is shown to be positive definite.

    False also if it is definite by less than about n 2^-64 of its diagonal.
    """
    n = len(matrix)
    if any(matrix[i][i] <= 0 for i in range(n)):
        return False
    shifts = [(matrix[i][i].bit_length() - BITS) // 2 for i in range(n)]
    rounded = [
        [_shifted(matrix[i][j], shifts[i] + shifts[j]) - n * (i == j) for j in range(i + 1)]
        for i in range(n)
    ]
    return positive_definite_integers(rounded)


def _shifted(value: int, places: int) -> int:
    """Return value / 2^places, rounded down."""
    return value >> places if places >= 0 else value << -places


def squared_reaches(P: Sequence[Row], rows: Sequence[Row]) -> list[Fraction] | None:
    """Return the largest (h xi)^2 on xi'P xi <= 1, h P^-1 h' for each row h.

    None where P is not symmetric positive definite.
    """
    if not is_symmetric(P):
        return None
    n = len(P)
    of_P = lcm(*(entry.denominator for row in P for entry in row))
    scales = [lcm(*(entry.denominator for entry in h)) for h in rows]
    whole = [row[: i + 1] for i, row in enumerate(to_integers(P))]
    # Of an added row the last entry is its own diagonal; the others among themselves are not used.
    added = [
        [*(int(entry * scale) for entry in h), 0] for h, scale in zip(rows, scales, strict=True)
    ]
    previous = 1
    for k in range(n):
        pivot = whole[k][k]
        if pivot <= 0:
            return None
        below = [whole[i][k] for i in range(k + 1, n)]
        for i in range(k + 1, n):
            row, factor = whole[i], whole[i][k]
            for j in range(k + 1, i + 1):
                row[j] = (row[j] * pivot - factor * below[j - k - 1]) // previous
        for row in added:
            factor = row[k]
            for j in range(k + 1, n):
                row[j] = (row[j] * pivot - factor * below[j - k - 1]) // previous
            row[n] = (row[n] * pivot - factor * factor) // previous
        previous = pivot
    return [
        Fraction(-row[n] * of_P, previous * scale**2)
        for row, scale in zip(added, scales, strict=True)
    ]
