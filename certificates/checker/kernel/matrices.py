"""Exact matrices: integers over one positive denominator, which avoids reducing fractions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from operator import mul

from takagi.certificates.checker.kernel import definite
from takagi.certificates.checker.kernel.refusal import Refused


@dataclass(frozen=True, slots=True)
class Matrix:
    """``rows / below``; operations refuse shapes that do not fit."""

    rows: list[list[int]]
    below: int = 1

    @classmethod
    def of(cls, rows: Sequence[Sequence[Fraction]]) -> Matrix:
        """Return a matrix of fractions."""
        below = lcm(*(entry.denominator for row in rows for entry in row))
        return cls([[v.numerator * (below // v.denominator) for v in row] for row in rows], below)

    @classmethod
    def identity(cls, size: int) -> Matrix:
        return cls([[int(i == j) for j in range(size)] for i in range(size)])

    @classmethod
    def zeros(cls, rows: int, columns: int) -> Matrix:
        return cls([[0] * columns for _ in range(rows)])

    @classmethod
    def diagonal(cls, values: Sequence[Fraction]) -> Matrix:
        """Return the square matrix with these numbers on its diagonal."""
        none, size = Fraction(0), range(len(values))
        return cls.of([[values[i] if i == j else none for j in size] for i in size])

    @classmethod
    def blocks(cls, grid: Sequence[Sequence[Matrix]]) -> Matrix:
        """Return [[M11, M12, ...], [M21, ...], ...] as one matrix."""
        below = lcm(*(M.below for row in grid for M in row))
        rows: list[list[int]] = []
        for line in grid:
            if len({len(M.rows) for M in line}) != 1:
                raise Refused("blocks of one row have different heights")
            scaled = [[v * (below // M.below) for v in row] for M in line for row in M.rows]
            height = len(line[0].rows)
            rows += [sum(scaled[i::height], []) for i in range(height)]
        if len({len(row) for row in rows}) != 1:
            raise Refused("rows of blocks have different widths")
        return cls(rows, below)

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.rows), len(self.rows[0])

    @property
    def T(self) -> Matrix:
        return Matrix([list(column) for column in zip(*self.rows, strict=True)], self.below)

    def __getitem__(self, index: tuple[int, int]) -> Fraction:
        return Fraction(self.rows[index[0]][index[1]], self.below)

    def __add__(self, other: Matrix) -> Matrix:
        if self.shape != other.shape:
            raise Refused(f"matrices of shape {self.shape} and {other.shape} cannot be added")
        below = lcm(self.below, other.below)
        s, t = below // self.below, below // other.below
        pairs = zip(self.rows, other.rows, strict=True)
        return Matrix([[s * a + t * b for a, b in zip(p, q, strict=True)] for p, q in pairs], below)

    def __neg__(self) -> Matrix:
        return Matrix([[-a for a in row] for row in self.rows], self.below)

    def __sub__(self, other: Matrix) -> Matrix:
        return self + -other

    def __rmul__(self, factor: Fraction | int) -> Matrix:
        exact = Fraction(factor)
        rows = [[exact.numerator * a for a in row] for row in self.rows]
        return Matrix(rows, self.below * exact.denominator)

    def __matmul__(self, other: Matrix) -> Matrix:
        if self.shape[1] != other.shape[0]:
            raise Refused(f"matrices of shape {self.shape} and {other.shape} cannot be multiplied")
        columns = list(zip(*other.rows, strict=True))
        rows = [[sum(map(mul, row, column)) for column in columns] for row in self.rows]
        return Matrix(rows, self.below * other.below)

    def reduced(self) -> Matrix:
        """Return the same matrix without the common factor of rows and denominator."""
        common = gcd(self.below, *(entry for row in self.rows for entry in row))
        rows = [[entry // common for entry in row] for row in self.rows]
        return Matrix(rows, self.below // common)

    @property
    def trace(self) -> Fraction:
        """The sum of the diagonal."""
        return Fraction(sum(self.rows[k][k] for k in range(len(self.rows))), self.below)

    def row(self, k: int) -> Matrix:
        """Return row k as a matrix of one row."""
        return Matrix([list(self.rows[k])], self.below)

    @property
    def is_symmetric(self) -> bool:
        return definite.is_symmetric(self.rows)

    @property
    def is_positive_definite(self) -> bool:
        """Whether the matrix is symmetric and x'Mx > 0 for every x but 0."""
        return self.is_symmetric and definite.positive_definite_integers(self.reduced().rows)

    @property
    def is_positive_semidefinite(self) -> bool:
        """Whether the matrix is symmetric and x'Mx >= 0 for every x."""
        return self.is_symmetric and definite.positive_definite_integers(
            self.reduced().rows, zero_passes=True
        )


def mean(matrices: Sequence[Matrix]) -> Matrix:
    """Return the arithmetic mean of one or more matrices."""
    return Fraction(1, len(matrices)) * sum(matrices[1:], matrices[0])
