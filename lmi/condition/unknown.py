"""An unknown of an LMI: a matrix, or several matrices of one shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.expressions.expression import Equation, Expression, Operators, by_rule
from takagi.lmi.expressions.piece import Piece
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError

Array: TypeAlias = NDArray[Any]


def triangle(size: int) -> int:
    """Return size (size + 1) / 2, the number of entries on and above the diagonal."""
    return size * (size + 1) // 2


@dataclass(frozen=True, slots=True)
class Unknown(Operators):
    """X_1 ... X_count, each (rows, cols); a scalar is 1 x 1.

    With operators it becomes a matrix expression, and with a comparison a statement for ``pose``:
    ``He(P @ A) << 0``.  Several members stand for one expression each; ``member`` picks one.

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

    def __eq__(self, other: object) -> Any:
        """Compare two unknowns as values; state an equation with anything else."""
        if isinstance(other, Unknown):
            return self._fields == other._fields
        return Equation(self - other)

    def __hash__(self) -> int:
        return hash(self._fields)

    @property
    def _fields(self) -> tuple[object, ...]:
        return self.name, self.rows, self.cols, self.symmetric, self.count, self.latex

    def as_expression(self) -> Expression:
        """Return the unknown as a matrix; with several members one matrix for each."""
        members = None if self.count == 1 else np.arange(self.count, dtype=np.intp)
        return self._expression(members)

    def member(self, number: int) -> Expression:
        """Return one of several members, counted from 0.

        Raises
        ------
        ModelError : there is no such member.
        """
        if not 0 <= number < self.count:
            raise ModelError(
                f"member {number} of unknown {self.name}; it has {self.count}, counted from 0"
            )
        return self._expression(np.array([number], dtype=np.intp))

    def over(self, rule: str) -> Expression:
        """Return the member of a rule of a Theta_ij: "i" the vertex's, "j" the gain's.

        One member is the same for all rules.
        """
        if self.count == 1:
            return self.as_expression()
        members = by_rule(np.arange(self.count, dtype=np.intp), rule)
        return self._expression(members, f"{self.symbol}_{{{rule}}}")

    def members(self, numbers: Indices, latex: str) -> Expression:
        """Return a member for each number (N,), or (r, r) for a Theta_ij, by the given symbol."""
        return self._expression(np.asarray(numbers, dtype=np.intp), latex)

    def _expression(self, members: Indices | None, symbol: str = "") -> Expression:
        left, right = np.eye(self.rows)[None], np.eye(self.cols)[None]
        piece = Piece(unknown=self, left=left, right=right, members=members, symbol=symbol)
        return Expression((self.rows,), (self.cols,), (piece,))

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

    def value(self, numbers: Array) -> Array:
        """Return (count, rows, cols) from the unknown's own numbers, (length,)."""
        members = np.arange(self.count)[:, None, None] * self.entries
        return np.asarray(numbers[members + self.entry_index()])

    def numbers(self, value: Array) -> Array:
        """Return (length,) in the arithmetic of the value: the inverse of ``value``."""
        flat = np.empty(self.length, dtype=value.dtype)
        members = np.arange(self.count)[:, None, None] * self.entries
        flat[members + self.entry_index()] = value
        return flat
