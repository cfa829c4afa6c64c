"""Definiteness of integer matrices, decided exactly.

Source: Bareiss (1968), Math. Comp. 22, fraction-free elimination: every pivot is a leading
principal minor, and by Sylvester a symmetric matrix is positive definite iff all are positive.
"""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.refusal import Refused

Rows = Sequence[Sequence[int]]
# Pivots grow to about size times bits bits, and there are size^3 products: about a minute.
MOST_WORK = 10**10


def positive_definite_integers(matrix: Rows, *, zero_passes: bool = False) -> bool:
    """Return whether a symmetric integer matrix is positive definite; the lower half is read.

    Parameters
    ----------
    zero_passes : accept semidefinite matrices: a zero pivot needs a zero column, then removed.
    """
    # Symmetry gives the upper half, so half of the products are saved.
    rows = [list(row[: i + 1]) for i, row in enumerate(matrix)]
    previous, size = 1, len(rows)
    bits = max((abs(entry).bit_length() for row in rows for entry in row), default=0)
    # The work is bounded before it begins: a hostile file could block the checker otherwise.
    if size**4 * bits > MOST_WORK:
        raise Refused(f"an inequality of order {size} with numbers of {bits} bits: too large")
    for k in range(size):
        pivot = rows[k][k]
        # In a semidefinite matrix a zero on the diagonal needs a zero row and column.
        if zero_passes and pivot == 0 and not any(rows[i][k] for i in range(k + 1, size)):
            continue
        if pivot <= 0:
            return False
        for i in range(k + 1, size):
            row, factor = rows[i], rows[i][k]
            for j in range(k + 1, i + 1):
                # The division is exact: the result is a minor of the matrix (Bareiss).
                row[j] = (row[j] * pivot - factor * rows[j][k]) // previous
        previous = pivot
    return True


def is_symmetric(matrix: Rows) -> bool:
    """Return whether a matrix is square, not empty, and equal to its transpose."""
    size = len(matrix)
    square = size > 0 and all(len(row) == size for row in matrix)
    return square and all(matrix[i][j] == matrix[j][i] for i in range(size) for j in range(i))
