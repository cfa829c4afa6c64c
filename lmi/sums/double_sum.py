"""Double sums over rules as data, and the LMIs that their weighted sums are.

A weighted sum of matrices Theta_ij, term by term; equal contributions are added up first.

The sum of h_i h_j Theta_ij that a law with memberships leads to, as terms of an LMI.

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
from typing import Literal, TypeAlias

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from takagi.lmi.condition.statements import printed_factors, symmetric_summands, whole_terms
from takagi.lmi.condition.term import LMI, Array, Constant, Labels, Position, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, Inequality
from takagi.lmi.expressions.piece import Piece
from takagi.lmi.sums.corner_rules import Corners, product_rules
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError

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


def term_of(part: SumPart, summand: Summand, scale: float) -> Term:
    """Return scale times the summand's sum of one part.

    If one side of the unknown is the same for all rules, contributions to one item with one member
    are added up beforehand, because the solver's data grow with the number of contributions.
    """
    left, right = part.left, part.right
    weight = scale * summand.weight
    members = _members(part, summand)
    items = summand.item
    if items is None:
        left = _scaled(weight, _picked(left, summand))
        right = None if right is None else _picked(right, summand)
    elif right is None or len(right) == 1:
        items, members, key = _keys(items, members, part.unknown.count)
        left = _gathered(left, summand, weight, key, len(items))
    elif len(left) == 1:
        items, members, key = _keys(items, members, part.unknown.count)
        right = _gathered(right, summand, weight, key, len(items))
    else:
        left, right = _scaled(weight, _picked(left, summand)), _picked(right, summand)
    return Term(
        unknown=part.unknown,
        left=left,
        right=right,
        at=part.at,
        plus_transpose=part.plus_transpose,
        items=items,
        members=members,
        parameter=part.parameter,
        latex=(_indexed(part.latex[0], summand.names), _indexed(part.latex[1], summand.names)),
        symbol=_indexed(part.symbol, summand.names),
        factor=_indexed(summand.factor, summand.names),
    )


def same_term(part: SumPart, total: Weights, scale: float, printed: float) -> Term:
    """Return a part that is the same in all Theta, times scale and the sum of the weights."""
    alike = bool(np.all(total == total[0]))
    return Term(
        unknown=part.unknown,
        left=_scaled(scale * (total[:1] if alike else total), part.left),
        right=part.right,
        at=part.at,
        plus_transpose=part.plus_transpose,
        parameter=part.parameter,
        latex=part.latex,
        symbol=part.symbol,
        factor=_number(total[0] / printed),
    )


def constant_of(
    fixed_block: KnownBlock,
    summands: Sequence[Summand],
    total: Weights,
    scale: float,
    printed: float,
) -> Iterator[Constant]:
    """Yield the sums of a known block: one if it is the same for all rules, else one a summand."""
    value, count = fixed_block.value, len(total)
    if value.ndim == 3 and len(value) == 1:
        alike = bool(np.all(total == total[0]))
        scaled_block = _scaled(scale * (total[:1] if alike else total), value)
        yield Constant(
            value=scaled_block,
            at=fixed_block.at,
            latex=fixed_block.latex,
            factor=_number(total[0] / printed),
        )
        return
    for summand in summands:
        weight = scale * summand.weight
        if summand.item is None:
            scaled_block = _scaled(weight, _picked(value, summand))
        else:
            scaled_block = _gathered(value, summand, weight, summand.item, count)
        yield Constant(
            value=scaled_block,
            at=fixed_block.at,
            latex=_indexed(fixed_block.latex, summand.names),
            factor=_indexed(summand.factor, summand.names),
        )


def _members(part: SumPart, summand: Summand) -> Indices | None:
    if not isinstance(part.member, str):
        return np.asarray(part.member[summand.i, summand.j])
    return {"first": None, "vertex": summand.i, "gain": summand.j}[part.member]


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
    if array.ndim == 4:
        return np.asarray(array[summand.i, summand.j])
    return array if len(array) == 1 else np.asarray(array[summand.i])


def _gathered(array: Array, summand: Summand, weight: Weights, key: Indices, count: int) -> Array:
    """Return (count, p, q): sum of weight_t array_t over the contributions t of one key."""
    if array.ndim == 4:
        flat, source = array.reshape(-1, *array.shape[2:]), summand.i * array.shape[1] + summand.j
    else:
        flat = array
        source = summand.i if len(array) > 1 else np.zeros_like(summand.i)
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
    rule_names = dict(zip("ij", names, strict=True))
    text = re.sub(r"(?<=[_^])\{([ij])\}", lambda match: "{" + rule_names[match[1]] + "}", text)
    return re.sub(r"(?<![_^])\{([ij])\}", lambda match: rule_names[match[1]], text)


def _number(value: float) -> str:
    return "" if value == 1 else f"{value:.4g}"


# The result of a relaxation: its own (slack) unknowns, and the LMIs.
RelaxedSum: TypeAlias = tuple[tuple[Unknown, ...], tuple[LMI, ...]]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DoubleSum:
    """sum_ij h_i h_j Theta_ij < 0 for all memberships h.

    Attributes
    ----------
    rules : r, the number of rules.
    blocks : sizes of Theta's diagonal blocks.
    parts, fixed : Theta_ij is the sum of these parts with unknowns and of these known blocks.
    weight : the margin that Theta must have when the other LMIs have margin 1.
    name : prefix of the LMIs' names, where a condition has more than one double sum.
    corners : (r, premises) which corner of each premise rule i takes, or ``ProductRules``; None
        where the memberships are not known to be products.
    active : (r, r), False where h_i h_j = 0 at every state; None where nothing is known.
    active_rules : at most this many h_i differ from zero at one state; None where nothing is known.
    """

    rules: int
    blocks: tuple[int, ...]
    parts: tuple[SumPart, ...]
    fixed: tuple[KnownBlock, ...] = ()
    weight: float = 1.0
    name: str = ""
    corners: Corners | None = None
    active: NDArray[np.bool_] | None = None
    active_rules: int | None = None

    def __post_init__(self) -> None:
        for part in self.parts:
            for side, array in (("left", part.left), ("right", part.right)):
                if array is not None:
                    self._check_length(f"part {part.unknown.name}, {side}", array)
            self._check_member(part)
        for known in self.fixed:
            self._check_length("a fixed block", known.value)
        if self.corners is not None and product_rules(self.corners).rules != self.rules:
            raise ModelError(
                f"corners: {product_rules(self.corners).rules} rules, but there are {self.rules}; "
                "give one row for each rule"
            )
        self._check_active()

    @property
    def size(self) -> int:
        """Return the size of Theta."""
        return sum(self.blocks)

    @property
    def by_gain(self) -> bool:
        """Return whether Theta_ij may change with j."""
        return any(part.by_gain for part in self.parts) or any(
            changes_with_gain(known.value) for known in self.fixed
        )

    @property
    def most_active(self) -> int:
        """Return the largest number of rules that act at one state."""
        active_rules = self.rules if self.active_rules is None else self.active_rules
        if self.active is None:
            return active_rules
        return min(active_rules, int(self.active.sum(axis=1).max()))

    def pairs(self) -> tuple[Indices, Indices]:
        """Return (i, j), i < j, of the pairs of rules that can act together."""
        i, j = np.triu_indices(self.rules, 1)
        if self.most_active == 1:
            return i[:0], j[:0]
        if self.active is None:
            return i, j
        keep = self.active[i, j]
        return i[keep], j[keep]

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
        varying = [part for part in self.parts if not part.same]
        terms = [term_of(part, summand, scale) for summand in summands for part in varying]
        terms += [same_term(part, total, scale, printed) for part in self.parts if part.same]
        constants = [
            constant
            for known in self.fixed
            for constant in constant_of(known, summands, total, scale, printed)
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

    def _check_length(self, owner: str, array: Array) -> None:
        r = self.rules
        if array.shape[:-2] not in ((1,), (r,), (r, r)):
            raise ModelError(
                f"{owner} has shape {array.shape}; (1, ., .), ({r}, ., .) or ({r}, {r}, ., .) is "
                "needed"
            )

    def _check_member(self, part: SumPart) -> None:
        r, count = self.rules, part.unknown.count
        if not isinstance(part.member, str):
            fits = part.member.shape == (r, r) and 0 <= part.member.min()
            fits = fits and int(part.member.max()) < count
        else:
            fits = part.member == "first" or count == r
        if not fits:
            raise ModelError(
                f"part {part.unknown.name} has {count} members for {r} rules; one for each rule, "
                f"or a table ({r}, {r}) of members is needed"
            )

    def _check_active(self) -> None:
        active, active_rules = self.active, self.active_rules
        if active is None and active_rules is None:
            return
        if active_rules is not None and not 1 <= active_rules <= self.rules:
            raise ModelError(
                f"active_rules is {active_rules}; 1 ... {self.rules} rules can act at a time"
            )
        r = self.rules
        if active is not None and (
            active.shape != (r, r) or not (active == active.T).all() or not active.diagonal().all()
        ):
            raise ModelError(
                f"active has shape {active.shape}; ({r}, {r}), symmetric, with every rule active "
                "by itself is needed; leave out a rule that never acts"
            )


def double_sum_of(
    statement: Inequality,
    *,
    rules: int,
    corners: Corners | None = None,
    active: NDArray[np.bool_] | None = None,
    active_rules: int | None = None,
) -> DoubleSum:
    """Return sum_ij h_i h_j Theta_ij < 0 of ``Theta << 0``, which is written with operators.

    Matrices ``over="i"`` and ``over="j"``, and unknowns ``.over("i")``, ``.over("j")``, change with
    the rule of the vertex and of the gain: ``He(A_i @ Q - B_i @ M_j) + 2 * alpha * Q << 0``.

    Parameters
    ----------
    statement : its name and its weight are those of the double sum.
    rules : r.
    corners, active, active_rules : as in ``DoubleSum``.

    Raises
    ------
    ModelError : ``>>``, ``<=`` or ``>=``; blocks that differ by row and column; other rules.
    """
    theta = statement.expression
    if statement.sign > 0 or not statement.strict:
        raise ModelError("double_sum_of of another comparison than <<; write Theta << 0")
    if theta.rows != theta.columns:
        raise ModelError(f"Theta has blocks of {theta.rows} rows and {theta.columns} columns")
    summands = list(symmetric_summands(theta))
    return DoubleSum(
        rules=rules,
        blocks=theta.rows,
        parts=tuple(_part(*summand, rules) for summand in summands if summand[0].unknown),
        fixed=tuple(_fixed(piece, rules) for piece, _ in summands if not piece.unknown),
        weight=statement.weight,
        name=statement.name,
        corners=corners,
        active=active,
        active_rules=active_rules,
    )


def _part(piece: Piece, plus_transpose: bool, rules: int) -> SumPart:
    sign, factor, before, behind = printed_factors(piece)
    assert isinstance(piece.unknown, Unknown)  # no other class is one
    member: Member = "first"
    if piece.members is not None:
        members, every = piece.members, np.arange(rules)
        if np.array_equal(members, every[:, None]):
            member = "vertex"
        elif np.array_equal(members, every[None]):
            member = "gain"
        else:
            member = np.broadcast_to(members, (rules, rules))
    glue = "" if before.startswith("\\") else " "
    return SumPart(
        unknown=piece.unknown,
        left=_by_rules(piece.scaled_left(), rules),
        right=None if piece.right is None else _by_rules(piece.right, rules),
        member=member,
        at=piece.at,
        plus_transpose=plus_transpose,
        parameter=None if piece.parameter is None else piece.parameter.name,
        latex=(sign + glue.join(text for text in (factor, before) if text), behind),
        symbol=piece.symbol,
    )


def _fixed(piece: Piece, rules: int) -> KnownBlock:
    sign, factor, before, _ = printed_factors(piece)
    latex = sign + " ".join(text for text in (factor, before or "I") if text)
    return KnownBlock(value=_by_rules(piece.scaled_left(), rules), at=piece.at, latex=latex)


def _by_rules(array: Array, rules: int) -> Array:
    """Return (1, p, q), (r, p, q) by the vertex's rule, or (r, r, p, q)."""
    lead, matrix_shape = array.shape[:-2], array.shape[-2:]
    if set(lead) == {1}:
        return array.reshape(1, *matrix_shape)
    if lead == (rules, 1):
        return array[:, 0]
    return np.broadcast_to(array, (rules, rules, *matrix_shape))


def selections(rules: int, states: int) -> Array:
    """Return E, (rules, rules states, states): E_i' X E_j is block (i, j) of X."""
    E = np.zeros((rules, rules * states, states))
    block = np.arange(rules)[:, None] * states + np.arange(states)
    E[np.arange(rules)[:, None], block, np.arange(states)] = 1.0
    return E
