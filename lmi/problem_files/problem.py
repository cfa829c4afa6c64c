r"""A conic problem as floats: what every reader of a file returns, and what a solver is given.

    minimise  c'x + c_0   subject to   S_k(x) = B_k + sum_i x_i A_ik  in  K_k

The cones and the order of a block's values are those of ``certificates/checker/problem``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal

import numpy as np
import scipy.sparse as sp

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

ZERO, NONNEGATIVE, SECOND_ORDER, SEMIDEFINITE = (
    "zero",
    "nonnegative",
    "second-order",
    "semidefinite",
)
ROOT = float(np.sqrt(2.0))


@dataclass(slots=True)
class Block:
    """One cone; ``entries`` (i, position) -> value, with i = 0 for B_k and i >= 1 for A_ik.

    ``scaled`` : values off the diagonal are sqrt(2) times those of the symmetric matrix.
    """

    cone: str
    size: int
    scaled: bool = False
    entries: dict[tuple[int, int], float] = field(default_factory=dict)

    @property
    def length(self) -> int:
        """The number of values."""
        return self.size * (self.size + 1) // 2 if self.cone == SEMIDEFINITE else self.size

    def add(self, index: int, position: int, value: float) -> None:
        """Add a value to an entry."""
        if value:
            key = (index, position)
            self.entries[key] = self.entries.get(key, 0.0) + value

    @property
    def on_diagonal(self) -> Floats:
        """Which values are on the diagonal of a semidefinite block, as ones and zeros."""
        diagonal = np.zeros(self.length)
        diagonal[[i * (i + 3) // 2 for i in range(self.size)]] = 1.0
        return diagonal

    @property
    def weights(self) -> Floats:
        """How often a value counts in the inner product, (length,)."""
        twice = self.cone == SEMIDEFINITE and not self.scaled
        return 2.0 - self.on_diagonal if twice else np.ones(self.length)

    @property
    def solver_scale(self) -> Floats:
        """The solver's value over the block's, (length,): solvers keep sqrt(2) off the diagonal."""
        return np.asarray(np.sqrt(self.weights))

    @property
    def interior(self) -> Floats:
        """A value well inside the cone: ones, (1, 0, ..., 0), or the identity; 0 for ``zero``."""
        if self.cone == SEMIDEFINITE:
            return self.on_diagonal
        if self.cone == NONNEGATIVE:
            return np.ones(self.size)
        inside = np.zeros(self.size)
        inside[0] = self.cone == SECOND_ORDER
        return inside

    def arrays(self, variables: int) -> tuple[sp.csr_array, Floats]:
        """Return A, (length, variables), and B, (length,)."""
        A, constant = sp.lil_array((self.length, variables)), np.zeros(self.length)
        for (index, position), value in self.entries.items():
            if index:
                A[position, index - 1] = value
            else:
                constant[position] = value
        return sp.csr_array(A), constant


@dataclass(frozen=True, slots=True)
class ConicProblem:
    """The problem of the module.

    Attributes
    ----------
    name : of the file.
    objective : c, (variables,);  offset : c_0.
    maximised : whether the file asks for the largest -(c'x + c_0).
    blocks : the cones with their values.
    rounded : how many numbers of the file have more digits than a float; they were rounded.
    """

    name: str
    objective: Floats
    offset: float
    maximised: bool
    blocks: tuple[Block, ...]
    rounded: int = 0

    @property
    def weights(self) -> Floats:
        """How often a value of all blocks, one after another, counts in the inner product."""
        return np.concatenate([block.weights for block in self.blocks])

    def stacked(self) -> tuple[sp.csr_array, Floats]:
        """Return A and B of all blocks, one above the other."""
        pairs = [block.arrays(len(self.objective)) for block in self.blocks]
        A = sp.csr_array(sp.vstack([a for a, _ in pairs]))
        return A, np.concatenate([constant for _, constant in pairs])

    def value(self, x: Floats) -> float:
        """Return the objective of the file at x."""
        value = float(self.objective @ x) + self.offset
        return -value if self.maximised else value


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver found: x, (variables,), and multipliers y of all blocks, or None."""

    x: Floats
    y: Floats | None = None


class Decimals:
    """Reads numbers of a text as floats, and counts those that a float does not hold."""

    def __init__(self, source: str) -> None:
        self.source, self.rounded = source, 0

    def __call__(self, text: str) -> float:
        """Return the float nearest to the text.

        Raises ModelError: no finite number.
        """
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise ModelError(f"{self.source}: {text!r} is not a finite number")
        # The certificate has the shortest decimals of the float.
        # Decimals, unlike fractions, do not write out what 1e-999999999 stands for.
        self.rounded += Decimal(repr(value)) != Decimal(text)
        return value


def triangle_position(row: int, column: int) -> int:
    """Return the position of an entry of a symmetric matrix in the lower triangle, row by row."""
    row, column = max(row, column), min(row, column)
    return row * (row + 1) // 2 + column


def require(holds: bool, source: str, needed: str) -> None:
    """Raise ModelError with the file's name where something needed is not there."""
    if not holds:
        raise ModelError(f"{source}: {needed}")


def values_by_block(blocks: Iterable[Block], stacked: Floats) -> list[Floats]:
    """Return a vector of all blocks in parts, one a block."""
    ends = np.cumsum([block.length for block in blocks])
    return np.split(stacked, ends[:-1])


def as_data(problem: ConicProblem) -> Mapping[str, object]:
    """Return the problem as the member ``model`` of a certificate."""
    return {
        "kind": "conic-problem",
        "name": problem.name,
        "objective": problem.objective.tolist(),
        "offset": problem.offset,
        "sense": "maximise" if problem.maximised else "minimise",
        "blocks": [
            {"cone": block.cone, "size": block.size}
            | ({"scaled": True} if block.scaled else {})
            | {"entries": [[i, k, v] for (i, k), v in sorted(block.entries.items())]}
            for block in problem.blocks
        ],
    }
