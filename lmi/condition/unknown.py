"""An unknown of an LMI: a matrix, or several matrices of one shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError


def triangle(size: int) -> int:
    """Return size (size + 1) / 2, the number of entries on and above the diagonal."""
    return size * (size + 1) // 2


@dataclass(frozen=True, slots=True)
class Unknown:
    """X_1 ... X_count, each (rows, cols); a scalar is 1 x 1.

    Attributes
    ----------
    name : the key of its value in a solution.
    rows, cols : the shape of one member.
    symmetric : members are symmetric, so only their upper triangle is solved for.
    count : number of members; 1 unless batched over rules or pairs.
    latex : symbol; the name when empty.

    The value of an unknown always has shape (count, rows, cols).
    """

    name: str
    rows: int
    cols: int
    symmetric: bool = False
    count: int = 1
    latex: str = ""

    def __post_init__(self) -> None:
        if min(self.rows, self.cols, self.count) < 1:
            raise ModelError(
                f"unknown {self.name}: {self.count} members of {self.rows} x {self.cols}; "
                "each of the three must be at least 1"
            )
        if self.symmetric and self.rows != self.cols:
            raise ModelError(
                f"unknown {self.name}: symmetric, but {self.rows} x {self.cols}; "
                "make it square or not symmetric"
            )

    @property
    def symbol(self) -> str:
        return self.latex or self.name

    @property
    def scalar(self) -> bool:
        return self.rows == self.cols == 1

    @property
    def entries(self) -> int:
        """Return how many numbers one member has."""
        return triangle(self.rows) if self.symmetric else self.rows * self.cols

    @property
    def length(self) -> int:
        """Return how many numbers all members have."""
        return self.count * self.entries

    def entry_index(self) -> Indices:
        """Return (rows, cols): the position of entry (k, l) among the numbers of its member.

        Symmetric: upper triangle, column by column.  Otherwise row by row.
        """
        if not self.symmetric:
            return np.arange(self.entries).reshape(self.rows, self.cols)
        row, column = np.indices((self.rows, self.cols))
        low, high = np.minimum(row, column), np.maximum(row, column)
        return np.asarray(high * (high + 1) // 2 + low)

    def value(self, numbers: Floats) -> Floats:
        """Return (count, rows, cols) from the unknown's own numbers, (length,)."""
        members = np.arange(self.count)[:, None, None] * self.entries
        return np.asarray(numbers[members + self.entry_index()])

    def numbers(self, value: Floats) -> Floats:
        """Return (length,): the inverse of ``value``."""
        flat = np.empty(self.length)
        members = np.arange(self.count)[:, None, None] * self.entries
        flat[members + self.entry_index()] = value
        return flat
