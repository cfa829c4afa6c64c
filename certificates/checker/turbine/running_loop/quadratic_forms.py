r"""A form with long entries, rounded to one with short entries that is definite only if it is.

With D = diag(2^-e_i), entries of D M D are rounded down to integers: D M D = R + E, E symmetric
with entries from 0 to 1, so its eigenvalues are at most n in size.  If R - n I > 0 then M > 0.  The
e_i make the diagonal of D M D about 2^BITS, so that n is negligible.
"""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.matrices import Matrix

BITS = 64


def rounded_form(matrix: Sequence[Sequence[int]]) -> Matrix:
    """Return R - n I of a symmetric integer matrix M; if it is positive definite, so is M."""
    n = len(matrix)
    shifts = [(matrix[i][i].bit_length() - BITS) // 2 for i in range(n)]
    return Matrix(
        [
            [_shifted(matrix[i][j], shifts[i] + shifts[j]) - n * (i == j) for j in range(n)]
            for i in range(n)
        ]
    )


def _shifted(value: int, places: int) -> int:
    """Return value / 2^places, rounded down."""
    return value >> places if places >= 0 else value << -places
