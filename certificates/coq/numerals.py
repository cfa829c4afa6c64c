r"""A positive definite integer matrix M, and a smaller matrix N that proves it: M, s, N.

    N_ij = round(M_ij / (s_i s_j)),    N_ii = floor(M_ii / s_i^2) - (n - 1)

with powers of two s_i.  The rounding error of each entry off the diagonal is at most s_i s_j; the
n - 1 units subtracted on the diagonal cover it: x'Mx >= y'Ny with y_i = s_i x_i.  So M is positive
definite if N is, and N has entries of a few digits if M is not nearly singular.  ``definite.v``
proves this, and Coq's kernel computes with N.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import is_definite

BITS = (12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024, 4096)
Rows = list[list[int]]


class Shorter(NamedTuple):
    """M over some positive denominator, the units s, and N."""

    matrix: Rows
    units: list[int]
    rounded: Rows


def whole_numbers(matrix: fmpq_mat) -> Rows:
    """Return a positive multiple of a matrix, without fractions."""
    whole, _ = matrix.numer_denom()
    return [[int(whole[i, j]) for j in range(whole.ncols())] for i in range(whole.nrows())]


def shorter(matrix: fmpq_mat) -> Shorter | None:
    """Return M, s and N with N positive definite; None where M is not symmetric and definite."""
    if not is_definite(matrix):
        return None
    whole = whole_numbers(matrix)
    n = len(whole)
    for bits in BITS:
        # If the entries have fewer bits than N should have, all are multiplied by one factor.
        up = max(0, bits - min(whole[i][i].bit_length() for i in range(n)))
        M = [[entry << up for entry in row] for row in whole]
        e = [max(0, (M[i][i].bit_length() - bits) // 2) for i in range(n)]
        N = [[_nearest(M[i][j], e[i] + e[j]) for j in range(n)] for i in range(n)]
        for i in range(n):
            N[i][i] = (M[i][i] >> 2 * e[i]) - (n - 1)
        if is_definite(fmpq_mat([[fmpq(entry) for entry in row] for row in N])):
            return Shorter(M, [1 << k for k in e], N)
    return None


def _nearest(value: int, shift: int) -> int:
    return (value + (1 << shift >> 1)) >> shift


def text_of(rows: Rows) -> str:
    """Return the upper triangle of a symmetric matrix as ``definite.v`` reads it."""
    triangle = (row[i:] for i, row in enumerate(rows))
    return "".join(",".join(map(str, row)) + ",/" for row in triangle) + ";"
