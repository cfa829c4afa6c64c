"""An LMI as data: sums of L X R with constants, batched over vertices, in blocks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.condition.unknown import Unknown
from takagi.models.arrays import Indices, ShortRepr
from takagi.models.errors import ModelError


def selected_items(lmi: LMI, items: Indices | range) -> LMI:
    """Return the LMI with these items only, in this order; each item keeps its label.

    ``items`` : different indices below ``lmi.count``; a range of step 1 copies nothing where it
    can.
    """
    chosen = slice(items.start, items.stop) if isinstance(items, range) else np.asarray(items)
    number = np.arange(items.start, items.stop) if isinstance(items, range) else np.asarray(items)
    new_index = np.full(lmi.count, -1, dtype=np.intp)
    new_index[number] = np.arange(len(number))
    return replace(
        lmi,
        terms=tuple(t for term in lmi.terms for t in _terms(term, lmi.count, chosen, new_index)),
        constants=tuple(_constant(constant, lmi.count, chosen) for constant in lmi.constants),
        count=len(number),
        labels=Labels(len(number), lambda k: lmi.label(int(number[k]))),
    )


def _terms(term: Term, count: int, chosen: slice | Indices, new_index: Indices) -> Iterator[Term]:
    """Yield the term with the contributions that are left, if there are any."""
    if term.items is None:
        yield _with(term, count, chosen)
        return
    selected = np.flatnonzero(new_index[term.items] >= 0)
    if len(selected):
        yield replace(_with(term, len(term.items), selected), items=new_index[term.items[selected]])


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


def _of(array: Array, length: int, chosen: slice | Indices) -> Array:
    """Return the chosen entries of an array with an entry for each item; a single entry stays."""
    return array[chosen] if len(array) == length and length > 1 else array


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


# float64, or objects that are exact fractions: builders pass either through unchanged.
Array: TypeAlias = NDArray[Any]
Position: TypeAlias = tuple[int, int]

# The default tolerance of a non-strict LMI, relative to its size.
TOLERANCE = 1e-7


class Spread(NamedTuple):
    """A term written out: contribution t adds left[t] X[member[t]] right[t] to item[t]."""

    item: Indices
    member: Indices
    left: Array
    right: Array | None


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Term(ShortRepr):
    """Contributions L_t X_member(t) R_t (+ transpose), t = 1 ... T, to items item(t) of an LMI.

    Attributes
    ----------
    unknown : X.
    left : (T, p, X.rows), or (1, p, X.rows) for the same in all.
    right : (T, X.cols, q) or (1, X.cols, q); None for a scalar X, then left is (T, p, q) and the
        contribution is X * left.
    at : block row and block column.  A block off the diagonal stands for its mirror image too.
        None is the whole matrix.
    plus_transpose : add the transpose; on the diagonal, or in the whole, only.
    items : (T,); None means one contribution to each item of the LMI.
    members : (T,); None means the first member everywhere.
    parameter : name of a number that multiplies the term, or None.
    latex : what is written before and behind the unknown, e.g. ``("A_i^\\top", "")``.
    symbol : the unknown with its index, e.g. ``"M_j"``; the unknown's own symbol when empty.
    factor : LaTeX of a number or sum that is part of left, e.g. ``"\\sum_j"``; terms that share
        it are written in one bracket.
    """

    unknown: Unknown
    left: Array
    right: Array | None = None
    at: Position | None = (0, 0)
    plus_transpose: bool = False
    items: Indices | None = None
    members: Indices | None = None
    parameter: str | None = None
    latex: tuple[str, str] = ("", "")
    symbol: str = ""
    factor: str = ""

    def spread(self, count: int) -> Spread:
        """Write the term out for an LMI of ``count`` items."""
        arrays = (self.left, self.right, self.items, self.members)
        size = max(len(array) for array in arrays if array is not None)
        size = count if self.items is None else size
        item = np.arange(size) if self.items is None else _repeated(self.items, size)
        member = np.zeros(1, dtype=np.intp) if self.members is None else self.members
        right = None if self.right is None else _repeated(self.right, size)
        return Spread(item, _repeated(member, size), _repeated(self.left, size), right)

    def picked(self, values: Mapping[str, Array]) -> Array:
        """Return its members of the unknown's values, one or one for each contribution."""
        value = values[self.unknown.name]
        return value[:1] if self.members is None else value[self.members]

    @property
    def shape(self) -> tuple[int, int]:
        """Return the shape of the block it fills."""
        columns = self.left if self.right is None else self.right
        return int(self.left.shape[1]), int(columns.shape[2])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Constant(ShortRepr):
    """A known block: value (N, p, q), or (1, p, q) for the same in every item.

    ``at``, ``factor`` as in ``Term``; the whole matrix must be symmetric.
    """

    value: Array
    at: Position | None = (0, 0)
    latex: str = ""
    factor: str = ""

    @property
    def shape(self) -> tuple[int, int]:
        return int(self.value.shape[1]), int(self.value.shape[2])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class LMI(ShortRepr):
    """F_k(X) = sum of terms + constants, and sign F_k(X) > 0 for every item k.

    A strict LMI holds with a margin t > 0. A non-strict one, sign F_k(X) >= 0, may hold with
    equality: it does not count for the margin, and it holds if the smallest eigenvalue of

        N_k^(-1/2) sign F_k(X) N_k^(-1/2)

    is at least -tolerance.  N_k is diagonal: the sum of the absolute values that are summed up on
    the diagonal of F_k, and no less than the largest constant of the item, or 1 where it has none.
    So x <= b is satisfied to within 2 tolerance b, in any units.

    Attributes
    ----------
    name : what it says, in words.
    blocks : sizes of the diagonal blocks; their sum is the size of F.
    terms, constants : what is summed.
    sign : 1 for F >= 0, -1 for F <= 0.
    count : number of items, one cone each.
    weight : a strict LMI holds with margin t when sign F >= t weight I; 0 says the same as
        ``strict=False``, and every non-strict LMI has it.
    strict : False for an LMI that may hold with equality.
    tolerance : by how much a non-strict LMI may be violated, as above.
    labels : one name per item, made when it is asked for if it is ``Labels``; ``"<name> 3 of 8"``
        when empty.
    index : LaTeX of the index range, e.g. ``"i = 1, \\dots, 8"``.
    """

    name: str
    blocks: tuple[int, ...]
    terms: tuple[Term, ...]
    constants: tuple[Constant, ...] = ()
    sign: int = 1
    count: int = 1
    weight: float = 1.0
    strict: bool = True
    tolerance: float = TOLERANCE
    labels: Sequence[str] = ()
    index: str = ""

    def __post_init__(self) -> None:
        if self.sign not in (1, -1):
            raise ModelError(f"LMI {self.name}: sign is {self.sign}; give 1 for >= 0, -1 for <= 0")
        if not 0 <= self.weight < math.inf:
            raise ModelError(
                f"LMI {self.name}: weight is {self.weight!r}; a positive number is needed, or "
                "strict=False for an LMI that may be touched"
            )
        if not 0 <= self.tolerance < 1:
            raise ModelError(
                f"LMI {self.name}: tolerance is {self.tolerance!r}; a number from 0 to below 1 is "
                "needed, the share of its size by which a non-strict LMI may be missed"
            )
        if not self.strict or self.weight == 0:
            object.__setattr__(self, "strict", False)
            object.__setattr__(self, "weight", 0.0)
        if self.labels and len(self.labels) != self.count:
            raise ModelError(
                f"LMI {self.name}: {len(self.labels)} labels for {self.count} items; name each"
            )
        for number, constant in enumerate(self.constants, start=1):
            owner = f"LMI {self.name}, constant {number}"
            _check_block(owner, constant.at, constant.shape, self.blocks)
            _check_length(owner, {"value": len(constant.value)}, self.count)
        for number, term in enumerate(self.terms, start=1):
            _check_term(f"LMI {self.name}, term {number} ({term.unknown.name})", term, self)

    @property
    def size(self) -> int:
        return sum(self.blocks)

    def spans(self, at: Position | None) -> tuple[slice, slice]:
        """Return the rows and the columns of a block, or of the whole."""
        return _spans(self.blocks, at)

    def label(self, item: int) -> str:
        """Return the name of one item."""
        if self.labels:
            return self.labels[item]
        return self.name if self.count == 1 else f"{self.name} {item + 1} of {self.count}"


@lru_cache(maxsize=1024)
def _spans(blocks: tuple[int, ...], at: Position | None) -> tuple[slice, slice]:
    """Return ``LMI.spans``; kept, since each term and constant asks at every evaluation."""
    if at is None:
        return slice(0, sum(blocks)), slice(0, sum(blocks))
    first, second = (sum(blocks[:k]) for k in at)
    return slice(first, first + blocks[at[0]]), slice(second, second + blocks[at[1]])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Equality(ShortRepr):
    """E_k(X) = sum of terms + constants = 0, every entry of it, for every item k.

    E is the block (0, 1) of a symmetric matrix with the blocks (p, q): a term at (0, 1) adds
    L X R, a term at (1, 0) adds (L X R)', which is how a transposed unknown is written.

    Attributes
    ----------
    name : what it says, in words.
    shape : (p, q) of E.
    terms, constants : what is summed; no term has a parameter, with which the space of solutions
        would move.
    count, labels, index : as in ``LMI``.
    """

    name: str
    shape: tuple[int, int]
    terms: tuple[Term, ...]
    constants: tuple[Constant, ...] = ()
    count: int = 1
    labels: Sequence[str] = ()
    index: str = ""

    def __post_init__(self) -> None:
        summands: tuple[Term | Constant, ...] = (*self.terms, *self.constants)
        for summand in summands:
            if summand.at not in ((0, 1), (1, 0)):
                raise ModelError(
                    f"equality {self.name}: a part at {summand.at}; (0, 1) is needed, or (1, 0) "
                    "for a transpose"
                )
        for term in self.terms:
            if term.parameter is not None:
                raise ModelError(
                    f"equality {self.name}: the parameter {term.parameter} multiplies "
                    f"{term.unknown.name}; put its value into the data"
                )
        self.frame()  # checks the shapes

    def frame(self) -> LMI:
        """Return the symmetric matrix whose block (0, 1) is E, as an LMI, not to be solved."""
        return LMI(
            name=self.name,
            blocks=self.shape,
            terms=self.terms,
            constants=self.constants,
            count=self.count,
            strict=False,
            labels=self.labels,
            index=self.index,
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Condition(ShortRepr):
    """Find unknowns with every LMI satisfied, and the objective, if there is one, least.

    Attributes
    ----------
    name, source : what it proves and where it was published.
    unknowns : in the order of the solver's variables.
    lmis : all must hold, the strict ones with a margin.
    equalities : all must hold; ``takagi.lmi.parametrised`` solves them exactly.
    objective : unknown name -> (count, rows, cols); the sum of entrywise products is minimised.
    parameters : values of the named numbers in the terms.
    """

    name: str
    unknowns: tuple[Unknown, ...]
    lmis: tuple[LMI, ...]
    objective: Mapping[str, Array] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
    equalities: tuple[Equality, ...] = ()

    def __post_init__(self) -> None:
        names = [unknown.name for unknown in self.unknowns]
        if len(set(names)) != len(names):
            raise ModelError(f"condition {self.name}: unknowns {names}; names must differ")
        members: tuple[LMI | Equality, ...] = (*self.lmis, *self.equalities)
        titles = [member.name for member in members]
        if len(set(titles)) != len(titles):
            raise ModelError(
                f"condition {self.name}: LMIs {titles}; names must differ, because multipliers "
                "and diagnoses name an LMI"
            )
        for lmi in members:
            for term in lmi.terms:
                if term.unknown not in self.unknowns:
                    raise ModelError(
                        f"condition {self.name}, {lmi.name}: unknown {term.unknown.name} is "
                        f"not among {', '.join(names)}; add it to the unknowns"
                    )
                if term.parameter is not None and term.parameter not in self.parameters:
                    raise ModelError(
                        f"condition {self.name}, LMI {lmi.name}: parameter {term.parameter} has "
                        "no value; give it in parameters"
                    )
        by_name = {unknown.name: unknown for unknown in self.unknowns}
        for name, cost in self.objective.items():
            unknown = by_name.get(name)
            shape = None if unknown is None else (unknown.count, unknown.rows, unknown.cols)
            if cost.shape != shape:
                raise ModelError(
                    f"condition {self.name}: objective of {name} has shape {cost.shape}; "
                    f"{shape or 'an unknown of the condition'} is needed"
                )
        object.__setattr__(self, "objective", MappingProxyType(dict(self.objective)))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))

    def with_parameters(self, **values: float) -> Condition:
        """Return the same condition at other parameter values."""
        return replace(self, parameters={**self.parameters, **values})

    def refuse_equalities(self) -> None:
        """Raise where LMIs alone can be read: what reads them would leave the equalities out.

        Raises
        ------
        ModelError : it has equalities.
        """
        if self.equalities:
            raise ModelError(
                f"condition {self.name} has {len(self.equalities)} equalities (the first: "
                f"{self.equalities[0].name}); give parametrised(condition).condition, which has "
                "LMIs alone, in the numbers that the equalities leave free"
            )

    def with_lmis(self, *lmis: LMI, unknowns: tuple[Unknown, ...] = ()) -> Condition:
        """Return the condition with more LMIs, and more unknowns if they need them."""
        return replace(self, lmis=self.lmis + lmis, unknowns=self.unknowns + unknowns)


def _check_term(owner: str, term: Term, lmi: LMI) -> None:
    unknown, left, right = term.unknown, term.left, term.right
    if left.ndim != 3 or (right is not None and right.ndim != 3):
        raise ModelError(f"{owner}: left and right need three axes, (T, rows, columns)")
    if right is None and not unknown.scalar:
        raise ModelError(f"{owner}: right is None, which needs a 1 x 1 unknown; give right")
    if right is not None and (left.shape[2], right.shape[1]) != (unknown.rows, unknown.cols):
        raise ModelError(
            f"{owner}: left {left.shape} and right {right.shape} do not fit the unknown's "
            f"{unknown.rows} x {unknown.cols}"
        )
    _check_block(owner, term.at, term.shape, lmi.blocks)
    if term.plus_transpose and term.at is not None and term.at[0] != term.at[1]:
        raise ModelError(
            f"{owner}: plus_transpose off the diagonal; the mirror block is implied, leave it out"
        )
    lengths = {"left": len(left)}
    for name, array in (("right", right), ("items", term.items), ("members", term.members)):
        if array is not None:
            lengths[name] = len(array)
    _check_length(owner, lengths, lmi.count if term.items is None else len(term.items))
    for name, index, count in (
        ("items", term.items, lmi.count),
        ("members", term.members, unknown.count),
    ):
        if index is not None and index.size and not 0 <= index.min() <= index.max() < count:
            raise ModelError(f"{owner}: {name} must lie in 0 ... {count - 1}")


def _repeated(array: NDArray[Any], size: int) -> NDArray[Any]:
    """Return the part with ``size`` entries, from as many or from one."""
    return array if len(array) == size else np.broadcast_to(array, (size, *array.shape[1:]))


def _check_block(
    owner: str, at: Position | None, shape: tuple[int, int], blocks: tuple[int, ...]
) -> None:
    if at is None:
        if shape != (sum(blocks),) * 2:
            raise ModelError(
                f"{owner}: {shape[0]} x {shape[1]}, but the whole matrix is {sum(blocks)} square"
            )
        return
    if not all(0 <= k < len(blocks) for k in at):
        raise ModelError(f"{owner}: block {at} of an LMI with {len(blocks)} block rows")
    if shape != (blocks[at[0]], blocks[at[1]]):
        raise ModelError(
            f"{owner}: {shape[0]} x {shape[1]}, but block {at} is {blocks[at[0]]} x {blocks[at[1]]}"
        )


def _check_length(owner: str, lengths: Mapping[str, int], count: int) -> None:
    for name, length in lengths.items():
        if length not in (1, count):
            raise ModelError(f"{owner}: {name} has {length} entries; 1 or {count} are needed")


def identity_like(array: Array, size: int) -> Array:
    """Return (1, size, size), of Fractions where the array has them."""
    if array.dtype != object:
        return np.eye(size)[None]
    eye = np.full((1, size, size), Fraction(0), dtype=object)
    eye[:, range(size), range(size)] = Fraction(1)
    return eye
