r"""Definiteness of an integer matrix with long entries, from a rounded one with short entries.

With D = diag(2^-e_i), entries of D M D are rounded down to integers: D M D = R + E, E symmetric
with entries from 0 to 1, so its eigenvalues are at most n in size.  If R - n I > 0 then M > 0.  The
e_i make the diagonal of D M D about 2^BITS, so that n is negligible.
"""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.definite import positive_definite_integers

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
