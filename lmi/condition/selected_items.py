"""Some of an LMI's items, for the rounds that give only a few of many items to the solver."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from takagi.lmi.condition.term import LMI, Array, Constant, Term
from takagi.models.arrays import Indices


def selected_items(lmi: LMI, items: Indices | range) -> LMI:
    """Return the LMI with these items only, in this order; each item keeps its label.

    Parameters
    ----------
    items : different indices below ``lmi.count``; a range of step 1 copies nothing where it can.
    """
    chosen = slice(items.start, items.stop) if isinstance(items, range) else np.asarray(items)
    number = np.arange(items.start, items.stop) if isinstance(items, range) else np.asarray(items)
    place = np.full(lmi.count, -1, dtype=np.intp)
    place[number] = np.arange(len(number))
    return replace(
        lmi,
        terms=tuple(t for term in lmi.terms for t in _terms(term, lmi.count, chosen, place)),
        constants=tuple(_constant(constant, lmi.count, chosen) for constant in lmi.constants),
        count=len(number),
        labels=Labels(len(number), lambda k: lmi.label(int(number[k]))),
    )


def _terms(term: Term, count: int, chosen: slice | Indices, place: Indices) -> Iterator[Term]:
    """Yield the term with the contributions that are left, if there are any."""
    if term.items is None:
        yield _with(term, count, chosen)
        return
    kept = np.flatnonzero(place[term.items] >= 0)
    if len(kept):
        yield replace(_with(term, len(term.items), kept), items=place[term.items[kept]])


def _with(term: Term, length: int, chosen: slice | Indices) -> Term:
    return replace(
        term,
        left=_of(term.left, length, chosen),
        right=None if term.right is None else _of(term.right, length, chosen),
        members=None if term.members is None else _of(term.members, length, chosen),
        items=None,
    )


def _constant(constant: Constant, count: int, chosen: slice | Indices) -> Constant:
    return replace(constant, value=_of(constant.value, count, chosen))


def _of(part: Array, length: int, chosen: slice | Indices) -> Array:
    """Return the chosen entries of an array with an entry for each item; a single entry stays."""
    return part[chosen] if len(part) == length and length > 1 else part


@dataclass(frozen=True, slots=True, eq=False)
class Labels(Sequence[str]):
    """of(0), ..., of(size - 1) as a sequence.

    Attributes
    ----------
    size : how many.
    of : the name of item k, k = 0 ... size - 1.
    """

    size: int
    of: Callable[[int], str]

    def __len__(self) -> int:
        return self.size

    @overload
    def __getitem__(self, item: int) -> str: ...
    @overload
    def __getitem__(self, item: slice) -> tuple[str, ...]: ...
    def __getitem__(self, item: int | slice) -> str | tuple[str, ...]:
        if isinstance(item, slice):
            return tuple(self.of(k) for k in range(*item.indices(self.size)))
        # A range handles negative indices, and raises IndexError for those out of range.
        return self.of(range(self.size)[item])
