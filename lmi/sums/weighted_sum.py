"""A weighted sum of matrices Theta_ij, term by term; equal contributions are added up first."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np
import scipy.sparse as sp

from takagi.lmi.condition.term import Array, Constant, Term
from takagi.lmi.sums.summands import KnownBlock, Summand, SumPart, Weights
from takagi.models.arrays import Indices


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
