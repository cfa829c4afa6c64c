r"""Shortening of a matrix of long fractions; if the short one is definite, so is the matrix.

With D diagonal, its entries powers of 2 such that the diagonal of D M D is about 2^BITS, let
S_ij be the greatest integer at or below (D M D)_ij.  Then D M D = S + E, E symmetric with entries
from 0 to 1, and |x'Ex| <= n x'x.  So if S - n I is positive definite, M is positive definite.
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

BITS = 44


def shortened(matrix: fmpq_mat) -> fmpq_mat:
    """Return S - n I of the module's text; the matrix itself where a diagonal entry is not > 0."""
    n = matrix.nrows()
    diagonal = [matrix[i, i] for i in range(n)]
    if min(diagonal) <= 0:
        return matrix
    powers = [(BITS - _power(value)) // 2 for value in diagonal]
    rows = [[fmpq(0)] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            value = matrix[i, j] * fmpq(2) ** (powers[i] + powers[j])
            rows[i][j] = rows[j][i] = fmpq(int(value.p) // int(value.q) - n * int(i == j))
    return fmpq_mat(rows)


def _power(value: fmpq) -> int:
    """Return about the power of 2 that a positive number is."""
    return int(value.p).bit_length() - int(value.q).bit_length()
