"""The parts of Theta_ij in a double sum, and the weights of a sum of Theta_ij."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.condition.term import Array, Position
from takagi.lmi.condition.unknown import Unknown
from takagi.models.arrays import Floats, Indices

Weights: TypeAlias = Floats
# Which member of its unknown a part takes: the first, that of the vertex, that of the gain; or a
# table (r, r) of members.
Member: TypeAlias = Literal["first", "vertex", "gain"] | Indices


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SumPart:
    """L_ij X R_ij (+ transpose), one of the summands of Theta_ij.

    Attributes
    ----------
    left : (1, p, X.rows) for the same in all, (r, p, X.rows) by the vertex's rule i, or
        (r, r, p, X.rows) by both rules.
    right : the same, (., X.cols, q); None for a scalar X, then left is (., p, q).
    member : which member of X.
    at, plus_transpose, parameter : as in ``Term``.
    latex : before and behind the unknown, with ``{i}`` and ``{j}`` for the two rules, e.g.
        ``("-B_{i}", "")``.
    symbol : the unknown, e.g. ``"M_{j}"``; its own when empty.
    """

    unknown: Unknown
    left: Array
    right: Array | None = None
    member: Member = "first"
    at: Position | None = (0, 0)
    plus_transpose: bool = False
    parameter: str | None = None
    latex: tuple[str, str] = ("", "")
    symbol: str = ""

    @property
    def same(self) -> bool:
        """Return whether it is one and the same in every Theta_ij."""
        single = self.right is None or len(self.right) == 1
        return (
            isinstance(self.member, str)
            and self.member == "first"
            and (len(self.left) == 1 and single)
        )

    @property
    def by_gain(self) -> bool:
        """Return whether it changes with the gain's rule j."""
        arrays = [array for array in (self.left, self.right) if array is not None]
        if isinstance(self.member, str):
            return self.member == "gain" or any(map(changes_with_gain, arrays))
        return changes_with_gain(self.member[..., None, None]) or any(
            map(changes_with_gain, arrays)
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class KnownBlock:
    """A known block of Theta_ij: (1, p, q), (r, p, q) by the vertex's rule, or (r, r, p, q)."""

    value: Array
    at: Position | None = (0, 0)
    latex: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Summand:
    """weight_t Theta_(i_t, j_t), added to item item_t, for t = 1 ... T.

    Attributes
    ----------
    i, j : (T,) rule of the vertex, rule of the gain.
    weight : (T,); integers, or binary fractions, stay exact where the matrices are fractions.
    item : (T,); None means one to each item.
    names : the two indices in LaTeX, e.g. ``("i", "j")``.
    factor : the weight in LaTeX; empty for 1.
    """

    i: Indices
    j: Indices
    weight: Weights
    item: Indices | None = None
    names: tuple[str, str] = ("i", "j")
    factor: str = ""

    def totals(self, count: int) -> Weights:
        """Return the sum of the weights in each item, (count,)."""
        if self.item is None:
            return self.weight
        return np.asarray(np.bincount(self.item, self.weight, count), dtype=np.float64)


def changes_with_gain(array: Array) -> bool:
    """Return whether an array (1, ., .), (r, ., .) or (r, r, ., .) changes with its second rule."""
    return array.ndim == 4 and not bool((array == array[:, :1]).all())
