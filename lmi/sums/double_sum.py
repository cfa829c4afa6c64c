"""Double sums over rules as data, and the LMIs that their weighted sums are.

Theta_ij is a symmetric block matrix that is affine in the unknowns; i is the rule of the vertex, j
that of the gain.  A relaxation (``relaxations``) only needs weighted sums of the Theta_ij, not
their contents. Therefore every relaxation applies to every condition that is posed as a
``DoubleSum``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import prod
from typing import TypeAlias

import numpy as np
import scipy.sparse as sp

from takagi.lmi.condition.statements import printed_factors, symmetric_summands, whole_terms
from takagi.lmi.condition.term import LMI, Array, Constant, Labels, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, Inequality
from takagi.lmi.expressions.piece import Piece
from takagi.models.arrays import Floats, Indices, ShortRepr
from takagi.models.errors import ModelError

Weights: TypeAlias = Floats
# One of the matrices that make up Theta_ij, and whether its transpose is added.
Part: TypeAlias = tuple[Piece, bool]


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


def is_same(piece: Piece) -> bool:
    """Return whether it is one and the same in every Theta_ij."""
    return piece.members is None and set(piece.lead) == {1}


def changes_with_gain(piece: Piece) -> bool:
    """Return whether it changes with the gain's rule j."""
    arrays = [array for array in (piece.left, piece.right) if array is not None]
    if piece.members is not None:
        arrays.append(piece.members[..., None, None])
    return any(array.ndim == 4 and bool((array != array[:, :1]).any()) for array in arrays)


def term_of(part: Part, summand: Summand, scale: float) -> Term:
    """Return scale times the summand's sum of one part.

    If one side of the unknown is the same for all rules, contributions to one item with one member
    are added up beforehand, because the solver's data grow with the number of contributions.
    """
    piece, _ = part
    assert piece.unknown is not None  # a known matrix is a constant
    left, right = _stack(piece.scaled_left()), None if piece.right is None else _stack(piece.right)
    weight, items, members = scale * summand.weight, summand.item, _members(piece, summand)
    if items is None:
        left = _scaled(weight, _picked(left, summand))
        right = None if right is None else _picked(right, summand)
    elif right is None or right.ndim == 3:
        items, members, key = _keys(items, members, piece.unknown.count)
        left = _gathered(left, summand, weight, key, len(items))
    elif left.ndim == 3:
        items, members, key = _keys(items, members, piece.unknown.count)
        right = _gathered(right, summand, weight, key, len(items))
    else:
        left, right = _scaled(weight, _picked(left, summand)), _picked(right, summand)
    return _printed(part, left, right, summand.names, summand.factor, items, members)


def same_term(part: Part, total: Weights, scale: float, printed: float) -> Term:
    """Return a part that is the same in all Theta, times scale and the sum of the weights."""
    piece, _ = part
    left = _scaled(scale * _once(total), _stack(piece.scaled_left()))
    right = None if piece.right is None else _stack(piece.right)
    return _printed(part, left, right, ("i", "j"), _number(total[0] / printed), None, None)


def constants_of(
    piece: Piece, summands: Sequence[Summand], total: Weights, scale: float, printed: float
) -> Iterator[Constant]:
    """Yield the sums of a known block: one if it is the same for all rules, else one a summand."""
    sign, factor, before, _ = printed_factors(piece)
    latex = sign + " ".join(text for text in (factor, before or "I") if text)
    value = _stack(piece.scaled_left())
    if value.ndim == 3:
        yield Constant(
            value=_scaled(scale * _once(total), value),
            at=piece.at,
            latex=latex,
            factor=_number(total[0] / printed),
        )
        return
    for summand in summands:
        weight = scale * summand.weight
        if summand.item is None:
            scaled_block = _scaled(weight, _picked(value, summand))
        else:
            scaled_block = _gathered(value, summand, weight, summand.item, len(total))
        yield Constant(
            value=scaled_block,
            at=piece.at,
            latex=_indexed(latex, summand.names),
            factor=_indexed(summand.factor, summand.names),
        )


def _printed(
    part: Part,
    left: Array,
    right: Array | None,
    names: tuple[str, str],
    weight: str,
    items: Indices | None,
    members: Indices | None,
) -> Term:
    """Return the part as a term, with the names of its two rules."""
    piece, plus_transpose = part
    sign, factor, before, behind = printed_factors(piece)
    glue = "" if before.startswith("\\") else " "
    latex = sign + glue.join(text for text in (factor, before) if text)
    assert isinstance(piece.unknown, Unknown)  # no other class is one
    return Term(
        unknown=piece.unknown,
        left=left,
        right=right,
        at=piece.at,
        plus_transpose=plus_transpose,
        items=items,
        members=members,
        parameter=None if piece.parameter is None else piece.parameter.name,
        latex=(_indexed(latex, names), _indexed(behind, names)),
        symbol=_indexed(piece.symbol, names),
        factor=_indexed(weight, names),
    )


def _once(total: Weights) -> Weights:
    """Return the sums of the weights, a single one where all are alike."""
    return total[:1] if bool(np.all(total == total[0])) else total


def _stack(array: Array) -> Array:
    """Return (1, p, q) where it is the same for all rules, else (r or 1, r or 1, p, q)."""
    single = set(array.shape[:-2]) == {1}
    return array.reshape(1, *array.shape[-2:]) if single else array


def _members(piece: Piece, summand: Summand) -> Indices | None:
    if piece.members is None:
        return None
    table = np.atleast_2d(piece.members)
    return np.asarray(table[summand.i % table.shape[0], summand.j % table.shape[1]])


def _keys(
    items: Indices, members: Indices | None, count: int
) -> tuple[Indices, Indices | None, Indices]:
    """Return the pairs (item, member) that occur, and which of them each contribution is to."""
    if members is None:
        pairs, key = np.unique(items, return_inverse=True)
        return pairs, None, key
    pairs, key = np.unique(items * count + members, return_inverse=True)
    return pairs // count, pairs % count, key


def _picked(array: Array, summand: Summand) -> Array:
    """Return (T, p, q), or (1, p, q) where it does not depend on the rules."""
    if array.ndim == 3:
        return array
    # A rule that the array does not change with has one entry.
    return np.asarray(array[summand.i % array.shape[0], summand.j % array.shape[1]])


def _gathered(array: Array, summand: Summand, weight: Weights, key: Indices, count: int) -> Array:
    """Return (count, p, q): sum of weight_t array_t over the contributions t of one key."""
    rows, columns = (1, 1) if array.ndim == 3 else array.shape[:2]
    flat = array.reshape(-1, *array.shape[-2:])
    source = summand.i % rows * columns + summand.j % columns
    if array.dtype == object:
        total = np.full((count, *flat.shape[1:]), Fraction(0), dtype=object)
        np.add.at(total, key, _scaled(weight, flat[source]))
        return total
    sums = sp.csr_array((weight, (key, source)), shape=(count, len(flat)))
    return np.asarray(sums @ flat.reshape(len(flat), -1)).reshape(count, *flat.shape[1:])


def _scaled(weight: Weights, array: Array) -> Array:
    """Return weight_t array_t; fractions stay fractions, for binary weights without an error."""
    if (weight == 1.0).all():
        return array
    if array.dtype == object:
        exact = np.array([Fraction(w) for w in weight.tolist()], dtype=object)
        return np.asarray(exact[:, None, None] * array)
    return np.asarray(weight[:, None, None] * array)


def _indexed(text: str, names: tuple[str, str]) -> str:
    """Return the text with ``{i}``, ``{j}`` replaced by the names of the two rules.

    A name keeps its braces right behind ``_`` or ``^``; inside of others it needs none.
    """
    if "{" not in text:
        return text
    rule_names = dict(zip("ij", names, strict=True))
    text = re.sub(r"(?<=[_^])\{([ij])\}", lambda match: "{" + rule_names[match[1]] + "}", text)
    return re.sub(r"(?<![_^])\{([ij])\}", lambda match: rule_names[match[1]], text)


def _number(value: float) -> str:
    return "" if value == 1 else f"{value:.4g}"


# The result of a relaxation: its own (slack) unknowns, and the LMIs.
RelaxedSum: TypeAlias = tuple[tuple[Unknown, ...], tuple[LMI, ...]]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class DoubleSum(ShortRepr):
    """sum_ij h_i h_j Theta_ij < 0 for all memberships h.

    Attributes
    ----------
    rules : r, the number of rules.
    blocks : sizes of Theta's diagonal blocks.
    parts : Theta_ij is the sum of these matrices, and of the transposes of those that say so.
    weight : the margin that Theta must have when the other LMIs have margin 1.
    name : prefix of the LMIs' names, where a condition has more than one double sum.
    corners : (r, premises) which corner of each premise rule i takes, from 0, every combination
        once: h_i = prod_k w_(k, corner_ik), the weights of a premise nonnegative with sum 1.  None
        where the memberships are not known to be products.
    """

    rules: int
    blocks: tuple[int, ...]
    parts: tuple[Part, ...]
    weight: float = 1.0
    name: str = ""
    corners: Indices | None = None

    def __post_init__(self) -> None:
        for piece, _ in self.parts:
            if any(length not in (1, self.rules) for length in piece.lead) or (
                len(piece.lead) == 1 and set(piece.lead) != {1}
            ):
                owner = "a known matrix" if piece.unknown is None else piece.unknown.name
                raise ModelError(
                    f"the part with {owner} is for {' x '.join(map(str, piece.lead))} rules, but "
                    f'there are {self.rules}; one for each is needed, with over="i" or over="j"'
                )
        if self.corners is not None:
            _check_combinations(self.corners, self.rules)

    @property
    def size(self) -> int:
        """Return the size of Theta."""
        return sum(self.blocks)

    @property
    def by_gain(self) -> bool:
        """Return whether Theta_ij may change with j."""
        return any(changes_with_gain(piece) for piece, _ in self.parts)

    def pairs(self) -> tuple[Indices, Indices]:
        """Return (i, j), i < j, of the pairs of rules."""
        return np.triu_indices(self.rules, 1)

    def lmi(
        self,
        name: str,
        summands: Sequence[Summand],
        slack: Expression | None = None,
        *,
        count: int,
        label: Callable[[int], str],
        index: str,
        scale: float = 1.0,
        printed: float = 1.0,
    ) -> LMI:
        """Return the LMI scale (sum of the summands) + slack < 0, for each of ``count`` items.

        Parameters
        ----------
        slack : of the size of Theta, the same for all items or one for each.
        label : a function from k to the name of item k.
        scale : a positive factor, not printed.
        printed : the ratio of the solved sum to the formula that is printed.
        """
        # A part that is the same for all (i, j) enters once, times the sum of the weights.
        total = sum((summand.totals(count) for summand in summands), np.zeros(count))
        of_unknowns = [part for part in self.parts if part[0].unknown is not None]
        varying = [part for part in of_unknowns if not is_same(part[0])]
        terms = [term_of(part, summand, scale) for summand in summands for part in varying]
        terms += [
            same_term(part, total, scale, printed) for part in of_unknowns if is_same(part[0])
        ]
        constants = [
            constant
            for piece, _ in self.parts
            if piece.unknown is None
            for constant in constants_of(piece, summands, total, scale, printed)
        ]
        prefix = f"{self.name}, " if self.name else ""
        return LMI(
            name=f"{prefix}{name}",
            blocks=self.blocks,
            terms=(*terms, *(whole_terms(slack) if slack is not None else ())),
            constants=tuple(constants),
            sign=-1,
            count=count,
            weight=self.weight,
            labels=Labels(count, lambda item: f"{prefix}{label(item)}"),
            index=index,
        )


def _check_combinations(corners: Indices, rules: int) -> None:
    if corners.ndim != 2 or not corners.size or corners.dtype.kind not in "iu":
        raise ModelError(
            f"corners have shape {corners.shape} and type {corners.dtype}; integers "
            "(rules, premises) are needed"
        )
    if len(corners) != rules:
        raise ModelError(
            f"corners: {len(corners)} rules, but there are {rules}; give one row for each rule"
        )
    low, different = int(corners.min()), len(np.unique(corners, axis=0))
    combinations = prod(int(side) for side in corners.max(axis=0) + 1)
    if low < 0 or not different == combinations == rules:
        raise ModelError(
            f"corners: {rules} rules, {different} of them different, least index {low}, for "
            f"{combinations} combinations; every combination is needed once, from 0, or the "
            "memberships do not sum to 1"
        )


def double_sum_of(
    statement: Inequality, *, rules: int, corners: Indices | None = None
) -> DoubleSum:
    """Return sum_ij h_i h_j Theta_ij < 0 of ``Theta << 0``, which is written with operators.

    Matrices ``over="i"`` and ``over="j"``, and unknowns ``.over("i")``, ``.over("j")``, change with
    the rule of the vertex and of the gain: ``He(A_i @ Q - B_i @ M_j) + 2 * alpha * Q << 0``.

    Parameters
    ----------
    statement : its name and its weight are those of the double sum.
    rules : r.
    corners : as in ``DoubleSum``.

    Raises ModelError: ``>>``, ``<=`` or ``>=``; blocks that differ by row and column; other rules.
    """
    theta = statement.expression
    if statement.sign > 0 or not statement.strict:
        raise ModelError("double_sum_of of another comparison than <<; write Theta << 0")
    if theta.rows != theta.columns:
        raise ModelError(f"Theta has blocks of {theta.rows} rows and {theta.columns} columns")
    return DoubleSum(
        rules=rules,
        blocks=theta.rows,
        parts=tuple(symmetric_summands(theta)),
        weight=statement.weight,
        name=statement.name,
        corners=corners,
    )


def selections(rules: int, states: int) -> Array:
    """Return E, (rules, rules states, states): E_i' X E_j is block (i, j) of X."""
    E = np.zeros((rules, rules * states, states))
    block = np.arange(rules)[:, None] * states + np.arange(states)
    E[np.arange(rules)[:, None], block, np.arange(states)] = 1.0
    return E
