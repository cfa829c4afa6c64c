"""Exact matrices by FLINT, and the conditions of a claim."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check import flint_decider


def is_definite(matrix: fmpq_mat, *, strict: bool = True) -> bool:
    """Return whether a matrix is symmetric and positive definite; semidefinite if not strict."""
    if matrix.nrows() != matrix.ncols() or matrix != matrix.transpose():
        return False
    integers, _ = matrix.numer_denom()
    return flint_decider.is_definite(integers, strict=strict)


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
    for matrix in listed[1:]:
        total = total + matrix
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
    """``matrix`` is symmetric and positive definite, or semidefinite where ``strict`` is False."""

    label: str
    matrix: fmpq_mat
    strict: bool = True

    @property
    def holds(self) -> bool:
        return is_definite(self.matrix, strict=self.strict)


@dataclass(frozen=True, slots=True)
class Fact:
    """A decided condition other than definiteness of a matrix."""

    label: str
    holds: bool


Obligation: TypeAlias = Definite | Fact
Obligations: TypeAlias = Iterator[Obligation]
