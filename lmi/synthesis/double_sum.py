r"""Sums of h_i h_j Theta_ij, what a law with memberships makes of a condition, as terms of an LMI.

Theta_ij is a symmetric block matrix that is affine in the unknowns; i is the rule of the vertex, j
that of the gain.  A relaxation (``relaxations``) asks for weighted sums of such Theta_ij, and
never looks inside: whatever is posed as a ``DoubleSum`` has every relaxation.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.term import LMI, Array, Constant, Indices, Position, Term, Unknown
from takagi.models.errors import ModelError

__all__ = ["DoubleSum", "Fixed", "Part", "Summand", "selections"]

Weights: TypeAlias = NDArray[np.float64]
# Which member of its unknown a part takes: the first, that of the vertex, that of the gain; or a
# table (r, r) of members.
Member: TypeAlias = Literal["first", "vertex", "gain"] | Indices


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Part:
    """L_ij X R_ij (+ transpose), one of the summands of Theta_ij.

    Attributes
    ----------
    left : (1, p, X.rows) for the same in all, (r, p, X.rows) by the vertex's rule i, or
        (r, r, p, X.rows) by both.
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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fixed:
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
    weight : (T,).
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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DoubleSum:
    """sum_ij h_i h_j Theta_ij < 0 for all memberships h.

    Attributes
    ----------
    rules : r.
    blocks : sizes of Theta's diagonal blocks.
    parts, fixed : what Theta_ij is the sum of.
    weight : margin of Theta for a margin 1 of the other LMIs.
    name : prefix of the LMIs' names, where a condition has more than one double sum.
    corners : (r, premises) which corner of each premise rule i takes; None where the memberships
        are not known to be products.
    """

    rules: int
    blocks: tuple[int, ...]
    parts: tuple[Part, ...]
    fixed: tuple[Fixed, ...] = ()
    weight: float = 1.0
    name: str = ""
    corners: Indices | None = None

    def __post_init__(self) -> None:
        for part in self.parts:
            for side, array in (("left", part.left), ("right", part.right)):
                if array is not None:
                    self._check_length(f"part {part.unknown.name}, {side}", array)
        for known in self.fixed:
            self._check_length("a fixed block", known.value)

    def _check_length(self, what: str, array: Array) -> None:
        lengths = array.shape[:-2]
        if lengths not in ((1,), (self.rules,), (self.rules, self.rules)):
            raise ModelError(
                f"{what} has shape {array.shape}; (1, ., .), ({self.rules}, ., .) or "
                f"({self.rules}, {self.rules}, ., .) is needed"
            )

    @property
    def size(self) -> int:
        """Return the size of Theta."""
        return sum(self.blocks)

    def lmi(
        self,
        name: str,
        summands: Sequence[Summand],
        slack: Sequence[Term] = (),
        *,
        count: int,
        labels: tuple[str, ...],
        index: str,
    ) -> LMI:
        """Return: sum of the summands + slack < 0, for each of ``count`` items."""
        varying = [part for part in self.parts if not part.same]
        total = _total(summands, count)
        terms = [_term(part, summand) for summand in summands for part in varying]
        terms += [_scaled(part, total) for part in self.parts if part.same]
        constants = [_constant(known, summands, count, total) for known in self.fixed]
        prefix = f"{self.name}, " if self.name else ""
        return LMI(
            name=f"{prefix}{name}",
            blocks=self.blocks,
            terms=(*terms, *slack),
            constants=tuple(constants),
            sign=-1,
            count=count,
            weight=self.weight,
            labels=tuple(f"{prefix}{label}" for label in labels),
            index=index,
        )


def selections(rules: int, states: int) -> Array:
    """Return E, (rules, rules states, states): E_i' X E_j is block (i, j) of X."""
    E = np.zeros((rules, rules * states, states))
    block = np.arange(rules)[:, None] * states + np.arange(states)
    E[np.arange(rules)[:, None], block, np.arange(states)] = 1.0
    return E


def _total(summands: Sequence[Summand], count: int) -> Weights:
    """Return the sum of the weights in each item, (count,)."""
    total = np.zeros(count)
    for summand in summands:
        item = np.arange(count) if summand.item is None else summand.item
        np.add.at(total, item, summand.weight)
    return total


def _picked(array: Array, i: Indices, j: Indices) -> Array:
    """Return (T, p, q), or (1, p, q) where it does not depend on the rules."""
    if array.ndim == 4:
        return array[i, j]
    return array if len(array) == 1 else array[i]


def _term(part: Part, summand: Summand) -> Term:
    i, j = summand.i, summand.j
    left = summand.weight[:, None, None] * _picked(part.left, i, j)
    right = None if part.right is None else _picked(part.right, i, j)
    members: Indices | None = None
    if not isinstance(part.member, str):
        members = part.member[i, j]
    elif part.member != "first":
        members = i if part.member == "vertex" else j
    before, behind = (_indexed(text, summand.names) for text in part.latex)
    return Term(
        unknown=part.unknown,
        left=left,
        right=right,
        at=part.at,
        plus_transpose=part.plus_transpose,
        items=summand.item,
        members=members,
        parameter=part.parameter,
        latex=(_times(summand.factor, before), behind),
        symbol=_indexed(part.symbol, summand.names),
    )


def _scaled(part: Part, total: Weights) -> Term:
    """Return a part that is the same in all Theta, times the sum of the weights."""
    alike = bool(np.all(total == total[0]))
    left = total[:1, None, None] * part.left if alike else total[:, None, None] * part.left
    factor = "" if total[0] == 1 else f"{total[0]:.4g}"
    return Term(
        unknown=part.unknown,
        left=left,
        right=part.right,
        at=part.at,
        plus_transpose=part.plus_transpose,
        parameter=part.parameter,
        latex=(_times(factor, part.latex[0]), part.latex[1]),
        symbol=part.symbol,
    )


def _constant(known: Fixed, summands: Sequence[Summand], count: int, total: Weights) -> Constant:
    value, factor = known.value, "" if total[0] == 1 else f"{total[0]:.4g}"
    if value.ndim == 3 and len(value) == 1:
        return Constant(
            value=total[:, None, None] * value, at=known.at, latex=_times(factor, known.latex)
        )
    sums = np.zeros((count, *value.shape[-2:]), dtype=value.dtype)
    texts = []
    for summand in summands:
        item = np.arange(count) if summand.item is None else summand.item
        part = summand.weight[:, None, None] * _picked(value, summand.i, summand.j)
        np.add.at(sums, item, part)
        texts.append(_times(summand.factor, _indexed(known.latex, summand.names)))
    return Constant(value=sums, at=known.at, latex=" + ".join(texts) if known.latex else "")


def _indexed(text: str, names: tuple[str, str]) -> str:
    """Return the text with ``{i}``, ``{j}`` replaced by the names of the two rules."""
    given = dict(zip("ij", names, strict=True))
    return re.sub(r"\{([ij])\}", lambda found: "{" + given[found[1]] + "}", text)


def _times(factor: str, text: str) -> str:
    """Return factor times text: the sign of the text in front, two numbers multiplied."""
    if not factor:
        return text
    if text.startswith("-"):
        return f"-{_times(factor, text[1:])}"
    number = re.match(r"\d+(\.\d+)?", text)
    if number and re.fullmatch(r"\d+(\.\d+)?", factor):
        return f"{float(factor) * float(number[0]):.4g}{text[number.end() :]}"
    return f"{factor}{text}"
