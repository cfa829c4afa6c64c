r"""Exact matrices by FLINT, a test of definiteness, and the conditions of a claim.

All eigenvalues of a symmetric matrix are real.  With its characteristic polynomial

    det(x I - M) = x^n - c_1 x^(n-1) + c_2 x^(n-2) - ...,

where c_k is the k-th elementary symmetric function of the eigenvalues, all eigenvalues are
positive if and only if every c_k is positive, and no eigenvalue is negative if and only if no c_k
is negative (Descartes' rule of signs).  The first checker and the proof assistant use elimination;
this test does not, so that it cannot repeat an error of theirs.

Source: Horn and Johnson (2013), Matrix Analysis, theorem 7.2.1 and corollary 7.2.4, recalled.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq, fmpq_mat


def is_symmetric(matrix: fmpq_mat) -> bool:
    """Return whether a matrix is square and its own transpose."""
    return bool(matrix.nrows() == matrix.ncols() and matrix == matrix.transpose())


def is_definite(matrix: fmpq_mat, *, strict: bool = True) -> bool:
    """Return whether a matrix is symmetric and positive definite; semidefinite if not strict."""
    if not is_symmetric(matrix):
        return False
    # The common denominator is positive, so that it changes no sign of an eigenvalue: the
    # polynomial of the integers decides.
    whole, _ = matrix.numer_denom()
    coefficients = whole.charpoly().coeffs()
    n = matrix.nrows()
    for k in range(1, n + 1):
        c = coefficients[n - k] * (-1 if k % 2 else 1)
        if c < 0 or (strict and c == 0):
            return False
    return True


def identity(size: int) -> fmpq_mat:
    return fmpq_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])


def zeros(rows: int, columns: int) -> fmpq_mat:
    return fmpq_mat(rows, columns)


def diagonal(values: Sequence[fmpq]) -> fmpq_mat:
    n = len(values)
    return fmpq_mat(n, n, [values[i] if i == j else 0 for i in range(n) for j in range(n)])


def transposed(matrix: fmpq_mat) -> fmpq_mat:
    return matrix.transpose()


def negative(matrix: fmpq_mat) -> fmpq_mat:
    return matrix * fmpq(-1)


def scaled(factor: fmpq | int, matrix: fmpq_mat) -> fmpq_mat:
    return matrix * fmpq(factor)


def entries(matrix: fmpq_mat) -> list[list[fmpq]]:
    """Return the rows of a matrix."""
    return [[matrix[i, j] for j in range(matrix.ncols())] for i in range(matrix.nrows())]


def mean(matrices: Iterable[fmpq_mat]) -> fmpq_mat:
    """Return the mean of one or more matrices."""
    listed = list(matrices)
    total = listed[0]
    for one in listed[1:]:
        total = total + one
    return total * fmpq(1, len(listed))


def blocks(rows: Sequence[Sequence[fmpq_mat]]) -> fmpq_mat:
    """Return [[M11, M12, ...], [M21, ...], ...] as one matrix."""
    return fmpq_mat([
        [value for part in line for value in entries(part)[i]]
        for line in rows
        for i in range(line[0].nrows())
    ])  # fmt: skip


@dataclass(frozen=True, slots=True)
class Definite:
    """``matrix`` is symmetric and positive definite, or semidefinite where ``strict`` is False.

    ``label`` contains the checker's own words and never a text from the file: a forged file could
    otherwise print misleading lines.
    """

    label: str
    matrix: fmpq_mat
    strict: bool = True

    @property
    def holds(self) -> bool:
        return is_definite(self.matrix, strict=self.strict)

    @property
    def is_symmetric(self) -> bool:
        return is_symmetric(self.matrix)


@dataclass(frozen=True, slots=True)
class Fact:
    """A decided condition other than definiteness of a matrix."""

    label: str
    holds: bool


Obligation: TypeAlias = Definite | Fact
Obligations: TypeAlias = Iterator[Obligation]
