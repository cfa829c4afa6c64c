"""One summand of an expression: a number times L X R, L X' R, or a known matrix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from takagi.models.errors import ModelError

# float64, or objects that are all Fractions.
Data = NDArray[Any]
# A matrix without a name is printed entry by entry if it has at most so many entries.
PRINTED = 9


@dataclass(frozen=True, slots=True)
class Letter:
    """A symbol in a product, or its transpose; a symmetric one is its own transpose."""

    symbol: str
    symmetric: bool = False
    transposed: bool = False

    @property
    def text(self) -> str:
        if not self.transposed:
            return self.symbol
        if self.symbol.endswith(r"^\top"):
            return self.symbol.removesuffix(r"^\top")
        # TeX refuses a second superscript without braces.
        return (f"{{{self.symbol}}}" if "^" in self.symbol else self.symbol) + r"^\top"

    @property
    def T(self) -> Letter:
        return self if self.symmetric else replace(self, transposed=not self.transposed)


def turned(array: Data) -> Data:
    """Return the transposes of a stack of matrices."""
    return array.swapaxes(-1, -2)


def data_stack(value: object, owner: str) -> Data:
    """Return (N, p, q) of float64 or of Fractions; a matrix (p, q) and a number have N = 1.

    Decimal strings and Fractions stay exact.

    Raises
    ------
    ModelError : entries that are not numbers or not finite, or an array with one axis.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind in "OUS":
            exact = np.empty(array.shape, dtype=object)
            for index, entry in np.ndenumerate(array):
                if isinstance(entry, bool) or entry is None:
                    raise TypeError(f"{entry!r} in the place of a number")
                exact[index] = Fraction(entry if not hasattr(entry, "item") else entry.item())
            array = exact
        elif array.dtype.kind in "iuf":
            array = array.astype(np.float64)
        else:
            raise TypeError(f"entries of type {array.dtype}")
    except (TypeError, ValueError, OverflowError) as error:
        raise ModelError(
            f"{owner} cannot be read as a matrix of real numbers ({error}); give nested lists of "
            "equal length or a numpy array"
        ) from error
    if array.ndim == 0:
        array = array.reshape(1, 1, 1)
    if array.ndim not in (2, 3) or 0 in array.shape:
        raise ModelError(
            f"{owner} has shape {array.shape}; (p, q) is needed, or (N, p, q) for one matrix a "
            "vertex: a column of n numbers is (n, 1)"
        )
    if not np.isfinite(array.astype(np.float64)).all():
        raise ModelError(f"{owner} has an entry that is not finite; every entry must be")
    return array[None] if array.ndim == 2 else array


def number_text(number: float | Fraction) -> str:
    """Return a number as it is printed."""
    return f"{float(number):.6g}"


def identity_multiple(array: Data) -> float | Fraction | None:
    """Return c where every matrix of the stack is c I, else None."""
    p, q = array.shape[1:]
    c = array[0, 0, 0]
    same = p == q and bool(np.all(array == c * np.eye(p, dtype=np.intp)))
    return c if same else None


def symbol_of(array: Data) -> Letter:
    """Return the symbol of a matrix without a name: its entries, if they are few."""
    symmetric = array.shape[1] == array.shape[2] and bool(np.all(array == array.transpose(0, 2, 1)))
    if len(array) > 1 or array[0].size > PRINTED:
        return Letter(r"\mathrm{data}" + ("_{i}" if len(array) > 1 else ""), symmetric)
    rows = r" \\ ".join(" & ".join(number_text(entry) for entry in row) for row in array[0])
    if array[0].size == 1:
        return Letter(rows, symmetric=True)
    return Letter(rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}", symmetric)


Word = tuple[Letter, ...]


Members = np.ndarray[tuple[int, ...], np.dtype[np.intp]]


class NamedNumber(Protocol):
    """The properties of a parameter that an expression uses."""

    @property
    def name(self) -> str: ...
    @property
    def value(self) -> float | Fraction: ...


class Symbol(Protocol):
    """The properties of an unknown that an expression uses."""

    @property
    def name(self) -> str: ...
    @property
    def rows(self) -> int: ...
    @property
    def cols(self) -> int: ...
    @property
    def symmetric(self) -> bool: ...
    @property
    def count(self) -> int: ...
    @property
    def scalar(self) -> bool: ...


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Piece:
    """factor times left[t] X[members[t]] right[t], with X transposed where ``transposed``.

    Attributes
    ----------
    unknown : X, or None for a known matrix, which is ``left``.
    left, right : (N, p, a) and (N, b, q), or N = 1 for the same in all; right is None for a known
        matrix and for a scalar X, then left is (N, p, q). For two rules (r, r, ., .), with 1 in the
        place of a rule that it does not change with.
    members : (N,), or (r, r), index of the member of X; None for the first.
    items, item_count : (N,) to which of how many items each of the N is added; None for one each.
    transposed : X is.
    factor : a number that is not yet multiplied into ``left``.
    parameter : name and value of a named number that multiplies it.
    at : block row, block column; None is the whole matrix.
    mirror : it is what ``None`` in ``block`` stands for, so the other block is printed and solved.
    before, behind : symbols of left and of right, in order; a known matrix has ``before`` only.
    symbol : X with its index; empty for the default.
    sums : LaTeX of the sum over the N that are added to an item.
    """

    unknown: Symbol | None
    left: Data
    right: Data | None = None
    members: Members | None = None
    items: Members | None = None
    item_count: int = 1
    transposed: bool = False
    factor: float | Fraction = 1
    parameter: NamedNumber | None = None
    at: tuple[int, int] | None = (0, 0)
    mirror: bool = False
    before: Word = ()
    behind: Word = ()
    symbol: str = ""
    sums: str = ""

    @property
    def shape(self) -> tuple[int, int]:
        columns = self.left if self.right is None else self.right
        return int(self.left.shape[-2]), int(columns.shape[-1])

    @property
    def lead(self) -> tuple[int, ...]:
        """Return (N,), or (r, r) with 1 in the place of a rule that it does not change with."""
        if self.items is not None:
            return (self.item_count,)
        lead = self.left.shape[:-2]
        if self.right is not None and self.right.shape[:-2] != lead:
            lead = common_lead({lead, self.right.shape[:-2]})
        if self.members is not None and self.members.shape != lead:
            lead = common_lead({lead, self.members.shape})
        return lead

    @property
    def T(self) -> Piece:
        """Return the transpose, in the mirrored block."""
        at = None if self.at is None else self.at[::-1]
        if self.right is None:
            # A known matrix has symbols in ``before`` only, a scalar unknown on both sides.
            word = transposed(self.before + self.behind)
            before, behind = ((), word) if self.behind else (word, ())
            return replace(self, left=turned(self.left), at=at, before=before, behind=behind)
        assert self.unknown is not None  # a right factor belongs to an unknown
        return replace(
            self,
            left=turned(self.right),
            right=turned(self.left),
            at=at,
            transposed=not (self.transposed or self.unknown.symmetric or self.unknown.scalar),
            before=transposed(self.behind),
            behind=transposed(self.before),
        )

    def times(self, number: float | Fraction) -> Piece:
        return replace(self, factor=exact_product(self.factor, number))

    def before_it(self, known_piece: Piece, at: tuple[int, int] | None) -> Piece:
        """Return known times this piece, in a block."""
        return replace(
            self,
            at=at,
            left=product(known_piece.left, self.left),
            factor=exact_product(known_piece.factor, self.factor),
            parameter=single_parameter(known_piece, self),
            before=known_piece.before + self.before,
        )

    def behind_it(self, known_piece: Piece, at: tuple[int, int] | None) -> Piece:
        """Return this piece times known, in a block."""
        factor = exact_product(self.factor, known_piece.factor)
        parameter = single_parameter(self, known_piece)
        if self.right is None:
            left = product(self.left, known_piece.left)
            side = "behind" if self.behind else "before"
            word = {side: getattr(self, side) + known_piece.before}
            return replace(self, at=at, left=left, factor=factor, parameter=parameter, **word)
        return replace(
            self,
            at=at,
            right=product(self.right, known_piece.left),
            factor=factor,
            parameter=parameter,
            behind=self.behind + known_piece.before,
        )

    def scaled_left(self) -> Data:
        """Return left with the factor multiplied in."""
        if self.factor == 1:
            return self.left
        if isinstance(self.factor, Fraction) or self.left.dtype == object:
            return np.asarray(exact_array(self.left) * Fraction(self.factor))
        return np.asarray(self.left * float(self.factor))

    def value(self, values: Mapping[str, Any], count: int) -> Data:
        """Return the piece at given unknowns, (count, p, q) in floating point."""
        left = self.left.astype(np.float64) * float(self.factor)
        if self.unknown is None:
            block = left
        else:
            X = values[self.unknown.name][
                np.zeros(1, int) if self.members is None else self.members
            ]
            X = X.transpose(0, 2, 1) if self.transposed else X
            block = X * left if self.right is None else left @ X @ self.right.astype(np.float64)
        if self.items is not None:
            total = np.zeros((self.item_count, *block.shape[1:]))
            np.add.at(total, self.items, block)
            block = total
        return np.broadcast_to(block, (count, *block.shape[1:]))


def common_lead(leads: set[tuple[int, ...]]) -> tuple[int, ...]:
    """Return (N,), or (r, r), of parts that have as many items, or 1."""
    if len(leads) == 1:
        return next(iter(leads))
    if all(len(lead) == 1 for lead in leads):
        return (max(lead[0] for lead in leads),)
    return np.broadcast_shapes(*leads)


def single_parameter(first: Piece, second: Piece) -> NamedNumber | None:
    """Return the named number of a product.

    Raises
    ------
    ModelError : both factors have one.
    """
    if first.parameter is not None and second.parameter is not None:
        raise ModelError(
            f"a product of the parameters {first.parameter.name} and {second.parameter.name}; one "
            "parameter can multiply a term: give a Parameter for the product"
        )
    return first.parameter or second.parameter


def transposed(word: Word) -> Word:
    return tuple(letter.T for letter in reversed(word))


def product(first: Data, second: Data) -> Data:
    """Return the products of two stacks of matrices; exact where either is."""
    if is_identity(first):
        return second
    if is_identity(second):
        return first
    if first.dtype != second.dtype:
        first, second = exact_array(first), exact_array(second)
    return np.asarray(first @ second)


def is_identity(array: Data) -> bool:
    """Return whether a single matrix is the identity."""
    p, q = array.shape[-2:]
    return p == q and array.size == p * q and np.array_equal(array.reshape(p, q), _eye(p))


@lru_cache(maxsize=64)
def _eye(size: int) -> Data:
    return np.eye(size)


def exact_array(array: Data) -> Data:
    """Return Fractions; a float is the dyadic number it stores."""
    if array.dtype == object:
        return array
    fractions = np.empty(array.shape, dtype=object)
    for index, entry in np.ndenumerate(array):
        fractions[index] = Fraction(float(entry))
    return fractions


def entrywise(first: Data, second: Data) -> Data:
    """Return the entrywise products of two stacks, one of them 1 x 1; exact where either is."""
    if first.dtype != second.dtype:
        first, second = exact_array(first), exact_array(second)
    return np.asarray(first * second)


def exact_product(first: float | Fraction, second: float | Fraction) -> float | Fraction:
    if isinstance(first, Fraction) or isinstance(second, Fraction):
        return Fraction(first) * Fraction(second)
    return first * second
