"""Matrices that are affine in unknowns, written with operators; a comparison is a statement.

    P @ A, A.T @ P, P * A      products with known matrices: ``*`` is the matrix product too, and
                               scales where one of the two is a number or 1 x 1
    +, -, .T, 2 * P, P / 2     sums, transposes, scalings
    X << Y, X >> Y             Y - X, X - Y positive definite, with a margin
    X <= Y, X >= Y             semidefinite: equality is allowed
    X == Y                     equal entry by entry
    P[0, 0], P[:2, 1:]         entries and blocks, always as matrices; np.kron, np.trace, np.block

No statement is solved or tested here: ``takagi.lmi.pose`` makes a condition of statements.
An unknown with several members, or known matrices (N, p, q), mean one statement for each of N.
A ``Parameter`` is a number with a name, such as a decay rate: the condition keeps it, so that a
search can change its value. ``over="i"`` and ``over="j"`` make a matrix Theta_ij of two rules, for
``takagi.lmi.double_sum_of``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from numbers import Real
from typing import Any, NoReturn, cast

import numpy as np

from takagi.lmi.expressions.piece import (
    Letter,
    Piece,
    common_lead,
    data_stack,
    entrywise,
    exact_array,
    exact_product,
    identity_multiple,
    product,
    single_parameter,
    symbol_of,
    turned,
)
from takagi.models.errors import ModelError

AFFINE = (
    "an LMI is affine in its unknowns: fix one of the two factors, change variables (for gains: "
    "Y = K X), or give a scalar such as a decay rate as a number and search over it "
    "(``extreme_parameter``)"
)


class Operators(ABC):
    """The operators of the module's table, for unknowns and for expressions."""

    __slots__ = ()
    # With an array on the left of an operator, numpy then calls the methods below.
    __array_ufunc__ = None

    @abstractmethod
    def as_expression(self) -> Expression:
        """Return the matrix as a sum of pieces."""

    @property
    def T(self) -> Expression:
        """Return the transpose."""
        mine = self.as_expression()
        return Expression(mine.columns, mine.rows, tuple(piece.T for piece in mine.pieces))

    def __matmul__(self, other: object) -> Expression:
        return matrix_product(self.as_expression(), expression_of(other))

    def __rmatmul__(self, other: object) -> Expression:
        return matrix_product(expression_of(other), self.as_expression())

    def __mul__(self, other: object) -> Expression:
        return yalmip_product(self.as_expression(), other)

    def __rmul__(self, other: object) -> Expression:
        if isinstance(other, Real):
            return yalmip_product(self.as_expression(), other)
        return yalmip_product(expression_of(other), self.as_expression())

    def __truediv__(self, number: object) -> Expression:
        if isinstance(number, bool) or not isinstance(number, Real) or number == 0:
            raise ModelError(f"a matrix is divided by {number!r}; a number other than 0 is needed")
        mine = self.as_expression()
        return mine.scaled(1 / number if isinstance(number, Fraction) else 1.0 / float(number))

    def __pow__(self, power: object) -> NoReturn:
        raise ModelError(f"a power ({power!r}) of a matrix expression was written; {AFFINE}")

    def __neg__(self) -> Expression:
        return self.as_expression().scaled(-1)

    def __pos__(self) -> Expression:
        return self.as_expression()

    def __getitem__(self, key: Any) -> Expression:
        return selected(self.as_expression(), key)

    # Without this Python would ask for one row after another, and never be told to stop.
    __iter__ = None

    def __array_function__(
        self, function: Any, types: object, arguments: Any, options: dict[str, Any]
    ) -> Expression:
        known_functions: dict[Any, Any] = {np.kron: kron, np.trace: trace, np.block: block}
        if function not in known_functions or options:
            raise ModelError(
                f"{function.__module__}.{function.__name__} of an unknown or an expression; there "
                "are +, -, @, *, .T, slices, He, block, trace, np.kron, and log_det to be "
                "maximised: write it with these, or as an inequality with an unknown of its own"
            )
        return cast(Expression, known_functions[function](*arguments))

    def __add__(self, other: object) -> Expression:
        return total(self.as_expression(), other, 1)

    __radd__ = __add__

    def __sub__(self, other: object) -> Expression:
        return total(self.as_expression(), other, -1)

    def __rsub__(self, other: object) -> Expression:
        return total(-self, other, 1)

    def __lshift__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=-1, strict=True)

    def __rshift__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=1, strict=True)

    def __rlshift__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=1, strict=True)

    def __rrshift__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=-1, strict=True)

    def __le__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=-1, strict=False)

    def __ge__(self, other: object) -> Inequality:
        return Inequality(self - other, sign=1, strict=False)

    def __lt__(self, other: object) -> NoReturn:
        raise ModelError(
            "< and > compare numbers; write << or >> for a definite difference of matrices, <= or "
            ">= for a semidefinite one"
        )

    __gt__ = __lt__


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Expression(Operators):
    """A matrix in blocks, one for each of ``count`` items: the sum of its pieces.

    Attributes
    ----------
    rows, columns : sizes of the block rows and of the block columns.
    pieces : summands, each in its block.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    pieces: tuple[Piece, ...]

    def __post_init__(self) -> None:
        leads = {piece.lead for piece in self.pieces}
        if len(leads) < 2:
            return
        lengths = sorted(lead for lead in leads if set(lead) != {1})
        if len(lengths) < 2:
            return
        if any(len(lead) == 1 for lead in lengths) or len(set(sum(lengths, ()))) > 2:
            sizes = " and for ".join(" x ".join(map(str, lead)) for lead in lengths)
            raise ModelError(
                f"an expression has parts for {sizes} items; all parts must be of one number, or "
                "the same for all"
            )

    def as_expression(self) -> Expression:
        return self

    def __repr__(self) -> str:
        names = dict.fromkeys(str(piece.unknown.name) for piece in self.pieces if piece.unknown)
        several = f"{self.count} of " if self.count > 1 else ""
        of_unknowns = f" in {', '.join(names)}" if names else ""
        return f"Expression({several}{self.shape[0]} x {self.shape[1]}{of_unknowns})"

    @property
    def shape(self) -> tuple[int, int]:
        """Return the number of rows and of columns."""
        return sum(self.rows), sum(self.columns)

    @property
    def count(self) -> int:
        """Return how many matrices it stands for; r x r for a Theta_ij."""
        return math.prod(self.lead)

    @property
    def lead(self) -> tuple[int, ...]:
        """Return (N,), or (r, r) for a Theta_ij."""
        return common_lead({(1,), *(piece.lead for piece in self.pieces)})

    @property
    def known(self) -> bool:
        """Return whether it contains no unknown."""
        return all(piece.unknown is None for piece in self.pieces)

    def scaled(self, number: float | Fraction) -> Expression:
        """Return it times a number."""
        return replace(self, pieces=tuple(piece.times(number) for piece in self.pieces))

    def flat(self) -> Expression:
        r"""Return it as one block; in formulas E_i is block column i of the identity."""
        if len(self.rows) == len(self.columns) == 1:
            return self
        pieces = tuple(_lifted(piece, self.rows, self.columns) for piece in self.pieces)
        return Expression((self.shape[0],), (self.shape[1],), pieces)

    def __eq__(self, other: object) -> Equation:  # type: ignore[override]
        return Equation(self - other)

    __hash__ = object.__hash__


class Statement:
    """The result of a comparison of matrices; it is neither true nor false before it is solved."""

    __slots__ = ()

    def __bool__(self) -> NoReturn:
        raise ModelError(
            "a statement about unknowns was used as true or false; write two statements for a "
            "chain such as 0 << P << Q, and give all of them to pose()"
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Inequality(Statement):
    """sign times the expression is positive definite (strict), or semidefinite."""

    expression: Expression
    sign: int
    strict: bool
    name: str = ""
    index: str = ""
    weight: float = 1.0
    labels: Sequence[str] = ()

    def __repr__(self) -> str:
        symbol = {1: ">", -1: "<"}[self.sign] * (2 if self.strict else 1) + "=" * (not self.strict)
        return f"Inequality({self.expression!r} {symbol} 0)"

    def named(
        self, name: str, index: str = "", *, weight: float = 1.0, labels: Sequence[str] = ()
    ) -> Inequality:
        r"""Return it with a name.

        Parameters
        ----------
        index : LaTeX of an index range such as ``i = 1, \dots, 8``.
        weight : a strict inequality holds with the margin t when X >= t weight I.
        labels : a name for each of several matrices; "<name> 3 of 8" without.
        """
        return replace(self, name=name, index=index, weight=weight, labels=labels)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equation(Statement):
    """Every entry of the expression is zero."""

    expression: Expression
    name: str = ""
    index: str = ""

    def __repr__(self) -> str:
        return f"Equation({self.expression!r} == 0)"

    def named(self, name: str, index: str = "") -> Equation:
        """Return it with a name, and LaTeX of an index range."""
        return replace(self, name=name, index=index)


def expression_of(value: object, owner: str = "the matrix") -> Expression:
    """Return an expression: itself, an unknown, or known numbers."""
    if isinstance(value, Operators):
        return value.as_expression()
    if isinstance(value, Statement):
        raise ModelError("a statement was used as a matrix; compare two matrices in one statement")
    array = data_stack(value, owner)
    multiple = identity_multiple(array)
    p, q = array.shape[1:]
    if multiple is None:
        pieces: tuple[Piece, ...] = (Piece(unknown=None, left=array, before=(symbol_of(array),)),)
    elif multiple == 0:
        pieces = ()
    else:
        pieces = (Piece(unknown=None, left=np.eye(p)[None], factor=multiple),)
    if multiple is not None and array.dtype == object:
        pieces = tuple(replace(piece, left=exact_array(piece.left)) for piece in pieces)
    return Expression((p,), (q,), pieces)


def matrix_product(first: Expression, second: Expression) -> Expression:
    """Return first times second; one of the two must be known.

    Raises
    ------
    ModelError : shapes, or two unknowns in one product.
    """
    _refuse_two_unknowns(first, second)
    if first.shape[1] != second.shape[0]:
        raise ModelError(
            f"a product of {first.shape[0]} x {first.shape[1]} and {second.shape[0]} x "
            f"{second.shape[1]} matrices; the inner sizes must be equal"
        )
    parts = (*first.pieces, *second.pieces)
    if first.columns != second.rows or any(piece.at is None for piece in parts):
        first, second = first.flat(), second.flat()
    pieces = []
    for left_piece in first.pieces:
        for two in second.pieces:
            assert left_piece.at is not None and two.at is not None  # flat() leaves none
            if left_piece.at[1] == two.at[0]:
                at = left_piece.at[0], two.at[1]
                if left_piece.unknown is None:
                    pieces.append(two.before_it(left_piece, at))
                else:
                    pieces.append(left_piece.behind_it(two, at))
    return Expression(first.rows, second.columns, tuple(pieces))


def _refuse_two_unknowns(first: Expression, second: Expression) -> None:
    names = [
        "/".join(sorted({str(piece.unknown.name) for piece in factor.pieces if piece.unknown}))
        for factor in (first, second)
    ]
    if all(names):
        raise ModelError(f"a product of two unknowns ({names[0]} times {names[1]}): {AFFINE}")


def yalmip_product(first: Expression, factor: object) -> Expression:
    """Return first * other: a scaling where one is a number or 1 x 1, else the matrix product."""
    if isinstance(factor, Real) and not isinstance(factor, bool):
        number = factor if isinstance(factor, Fraction) else float(factor)
        if not np.isfinite(float(number)):
            raise ModelError(f"a matrix is multiplied by {number!r}; a finite number is needed")
        return first.scaled(number)
    second = expression_of(factor)
    _refuse_two_unknowns(first, second)
    if first.shape != (1, 1) and second.shape == (1, 1):
        first, second = second, first
    if first.shape != (1, 1) or second.shape[0] == 1:
        return matrix_product(first, second)
    if any(piece.unknown is not None and not piece.unknown.scalar for piece in first.pieces):
        return kron(first, second)
    pieces = [_scaling(number_piece, two) for number_piece in first.pieces for two in second.pieces]
    return Expression(second.rows, second.columns, tuple(pieces))


def total(first: Expression, summand: object, sign: int) -> Expression:
    """Return first + sign * other; the number 0 has any shape.

    Raises
    ------
    ModelError : another shape.
    """
    if isinstance(summand, Real) and not isinstance(summand, bool) and summand == 0:
        return first
    second = expression_of(summand)
    if first.shape != second.shape:
        raise ModelError(
            f"a {first.shape[0]} x {first.shape[1]} matrix and a {second.shape[0]} x "
            f"{second.shape[1]} one are added or compared; their shapes must be equal (a number c "
            "stands for c * np.eye(n) nowhere: write it out)"
        )
    if (first.rows, first.columns) != (second.rows, second.columns):
        first, second = _fitted(first, second), _fitted(second, first)
    return Expression(first.rows, first.columns, first.pieces + second.scaled(sign).pieces)


def _fitted(summand: Expression, other: Expression) -> Expression:
    """Return a matrix in one block as one on the whole of the other's blocks; else flat."""
    if len(summand.rows) == len(summand.columns) == 1:
        pieces = tuple(replace(piece, at=None) for piece in summand.pieces)
        return Expression(other.rows, other.columns, pieces)
    return summand if len(other.rows) == len(other.columns) == 1 else summand.flat()


def _scaling(scalar: Piece, two: Piece) -> Piece:
    """Return the 1 x 1 piece ``scalar`` times the piece ``two``; one of them is known."""
    parameter = single_parameter(scalar, two)
    factor = exact_product(scalar.factor, two.factor)
    if scalar.unknown is None:
        return replace(
            two,
            left=entrywise(scalar.left, two.left),
            factor=factor,
            parameter=parameter,
            before=scalar.before + two.before,
        )
    left = scalar.left if scalar.right is None else product(scalar.left, scalar.right)
    return replace(
        scalar,
        left=entrywise(left, two.left),
        right=None,
        factor=factor,
        parameter=parameter,
        at=two.at,
        before=(),
        behind=scalar.before + scalar.behind + (two.before or _identity_letter(two)),
    )


def kron(first: object, second: object) -> Expression:
    """Return the Kronecker product of two matrices, one of which is known.

    kron(M, X) = sum_k kron(M e_k, I) X kron(e_k', I), one term for each column of M.

    Raises
    ------
    ModelError : two unknowns.
    """
    one, two = expression_of(first).flat(), expression_of(second).flat()
    _refuse_two_unknowns(one, two)
    X, M = (two, one) if one.known else (one, two)

    def factor(known_matrix: Piece, size: int, text: str) -> Piece:
        pair = known_matrix.left, np.eye(size, dtype=np.intp)
        words = text, "I"
        left = np.kron(*(pair if X is two else pair[::-1]))
        symbol = r" \otimes ".join(words if X is two else words[::-1])
        return replace(known_matrix, left=left, before=(Letter(f"({symbol})"),))

    pieces: list[Piece] = []
    for piece in M.pieces:
        for k, e in enumerate(np.eye(M.shape[1], dtype=np.intp)[:, None, :, None]):
            name = f"e_{{{k + 1}}}"
            text = " ".join((*(letter.text for letter in piece.before), name))
            column = factor(replace(piece, left=piece.left[..., k : k + 1]), X.shape[0], text)
            row = factor(Piece(unknown=None, left=e), X.shape[1], name).T
            pieces += [part.before_it(column, (0, 0)).behind_it(row, (0, 0)) for part in X.pieces]
    rows, columns = np.multiply(one.shape, two.shape)
    return Expression((int(rows),), (int(columns),), tuple(pieces))


def selected(X: Expression, key: Any) -> Expression:
    """Return entries, rows or a block of a matrix by Python's indices; always a matrix.

    ``key`` : number, slice or list for the rows, or two of them, for rows and columns, from 0.

    Raises ModelError: another key, or one outside of the matrix.
    """
    keys = key if isinstance(key, tuple) else (key, slice(None))
    if X.count > 1 and not isinstance(key, tuple):
        raise ModelError(
            f"one index for {X.count} matrices; write X.member(0) for one of several, X[i, j] for "
            "the entry of each"
        )
    if len(keys) != 2:
        raise ModelError(f"{len(keys)} indices; a matrix has two, rows and columns")
    rows, columns = (_unit_rows(k, size) for k, size in zip(keys, X.shape, strict=True))
    return matrix_product(matrix_product(rows, X), columns.T)


def _unit_rows(key: Any, size: int) -> Expression:
    """Return the rows of the identity that an index picks."""
    try:
        picked = np.atleast_1d(np.arange(size)[key])
    except (IndexError, TypeError) as error:
        raise ModelError(f"index {key!r} of {size} rows or columns, counted from 0") from error
    if picked.ndim != 1 or not picked.size:
        raise ModelError(f"index {key!r} picks none of {size} rows or columns")
    if np.array_equal(picked, np.arange(size)):
        return placement(np.eye(size))
    letter = ("e" if picked.size == 1 else "E") + f"_{{{', '.join(str(k + 1) for k in picked)}}}"
    return matrix(np.eye(size)[picked].T, letter).T


def _identity_letter(piece: Piece) -> tuple[Letter, ...]:
    """Return I for a multiple of the identity; nothing for a ``placement``."""
    square = piece.shape[0] == piece.shape[1] and len(piece.left) == 1
    return (Letter("I", symmetric=True),) if square and identity_multiple(piece.left) else ()


def _lifted(piece: Piece, rows: tuple[int, ...], columns: tuple[int, ...]) -> Piece:
    """Return the piece of a block as a piece of the whole matrix."""
    if piece.at is None:
        return replace(piece, at=(0, 0))
    i, j = piece.at
    E, F = _block_column(rows, i), _block_column(columns, j)
    left = Piece(unknown=None, left=E, before=() if len(rows) == 1 else (Letter(f"E_{{{i + 1}}}"),))
    right = Piece(
        unknown=None,
        left=turned(F),
        before=() if len(columns) == 1 else (Letter(f"E_{{{j + 1}}}", transposed=True),),
    )
    return piece.before_it(left, (0, 0)).behind_it(right, (0, 0))


def _block_column(sizes: tuple[int, ...], k: int) -> Any:
    start = sum(sizes[:k])
    return np.eye(sum(sizes))[None, :, start : start + sizes[k]]


def pieces_at(expression: Expression, at: tuple[int, int] | None) -> Iterator[Piece]:
    """Yield the pieces of one block, or those on the whole."""
    return (piece for piece in expression.pieces if piece.at == at)


def matrix(value: object, latex: str, *, over: str = "") -> Expression:
    r"""Return a known matrix that formulas show by a symbol, e.g. ``matrix(A, "A_i")``.

    An unknown is an ``Unknown``.

    Parameters
    ----------
    value : (p, q), or (N, p, q) for one matrix a vertex; Fractions and decimal strings stay exact.
    latex : the symbol.
    over : "i" or "j": (r, p, q) is by this rule of a Theta_ij, and the symbol has ``{i}`` or
        ``{j}``; "ij": (r, r, p, q) is by both.

    Raises
    ------
    ModelError : not a matrix of finite numbers, or an empty symbol.
    """
    if isinstance(value, str) or not isinstance(latex, str):
        raise ModelError(
            f"matrix({value!r}, {latex!r}): known numbers and then their symbol are needed, as in "
            'matrix(A, "A_i"); for an unknown matrix write '
            'Unknown("P", 2, 2, symmetric=True)'
        )
    if not latex.strip():
        raise ModelError("matrix: the symbol is empty; give one, or use the array itself")
    pairs: tuple[int, ...] = np.asarray(value).shape if over == "ij" else ()
    stack = np.asarray(value).reshape(-1, *pairs[2:]) if pairs else value
    array = data_stack(stack, f"matrix {latex}")
    p, q = array.shape[1:]
    symmetric = p == q and bool(np.all(array == turned(array)))
    if over and (pairs or len(array) > 1):
        array = array.reshape(*pairs[:2], p, q) if pairs else by_rule(array, over)
    piece = Piece(unknown=None, left=array, before=(Letter(latex, symmetric),))
    return Expression((p,), (q,), (piece,))


def placement(value: object) -> Expression:
    """Return a known matrix that formulas leave out: it only puts what it multiplies in places."""
    known_matrix = matrix(value, "E")
    return replace(known_matrix, pieces=(replace(known_matrix.pieces[0], before=()),))


def identity(size: int) -> Expression:
    """Return I, printed as such whatever its size."""
    return matrix(np.eye(size), "I")


def by_rule(array: Any, over: str) -> Any:
    """Return (r, ...) as (r, 1, ...) over "i", as (1, r, ...) over "j".

    Raises
    ------
    ModelError : another name of a rule.
    """
    if over not in ("i", "j"):
        raise ModelError(f"over is {over!r}; 'i' (the vertex's rule) or 'j' (the gain's) is needed")
    return np.expand_dims(array, 1 if over == "i" else 0)


def added(
    value: object, items: Any = None, *, count: int = 1, latex: str = r"\sum_i"
) -> Expression:
    """Return the sum of several matrices: X_1 + ... + X_N, or several such sums.

    Parameters
    ----------
    value : an expression with N items.
    items : (N,) the sum to which each belongs; None adds all to one.
    count : number of sums.
    latex : the sum as it is written before a term.

    Raises
    ------
    ModelError : another number of items, an item of a sum that there is not.
    """
    X = expression_of(value)
    N = X.count
    target = np.zeros(N, dtype=np.intp) if items is None else np.asarray(items, dtype=np.intp)
    if target.shape != (N,) or not 0 <= target.min() <= target.max() < count:
        raise ModelError(
            f"a sum of {N} matrices into {count} with the items {target.tolist()}; {N} numbers "
            f"from 0 to {count - 1} are needed"
        )
    pieces = tuple(
        replace(piece, items=target, item_count=count, sums=latex, left=_repeated(piece.left, N))
        for piece in X.pieces
    )
    return replace(X, pieces=pieces)


def _repeated(array: Any, count: int) -> Any:
    return array if len(array) == count else np.broadcast_to(array, (count, *array.shape[1:]))


@dataclass(frozen=True, slots=True, eq=False)
class Parameter(Operators):
    """A number with a name that a condition keeps, so that a search can change its value.

    Attributes
    ----------
    name : the key of its value in ``Condition.parameters``, e.g. ``"alpha"``.
    value : the present value.
    latex : symbol; the name when empty.
    """

    name: str
    value: float | Fraction
    latex: str = ""

    def as_expression(self) -> Expression:
        """Return it as a 1 x 1 matrix, which scales what it multiplies."""
        letter = Letter(self.latex or self.name, symmetric=True)
        piece = Piece(unknown=None, left=np.eye(1)[None], parameter=self, before=(letter,))
        return Expression((1,), (1,), (piece,))


def He(value: object) -> Expression:
    """Return X + X'.

    Raises
    ------
    ModelError : X is not square.
    """
    X = expression_of(value)
    if X.shape[0] != X.shape[1]:
        raise ModelError(f"He of a {X.shape[0]} x {X.shape[1]} matrix; a square one is needed")
    return X + X.T


def trace(value: object) -> Expression:
    """Return the trace as a 1 x 1 expression, to be minimised or compared.

    Raises
    ------
    ModelError : X is not square.
    """
    X = expression_of(value).flat()
    n = X.shape[0]
    if n != X.shape[1]:
        raise ModelError(f"trace of a {n} x {X.shape[1]} matrix; a square one is needed")
    rows = np.eye(n)[:, None, None, :]
    pieces = []
    for piece in X.pieces:
        for row in rows:
            e = Piece(unknown=None, left=row)
            column = Piece(unknown=None, left=turned(row))
            entry = piece.before_it(e, (0, 0)).behind_it(column, (0, 0))
            if entry.left.any() and (entry.right is None or entry.right.any()):
                pieces.append(entry)
    return Expression((1,), (1,), tuple(pieces))


def block(rows: Sequence[Any]) -> Expression:
    """Return a block matrix; None stands for the transpose of the mirrored block, 0 for zeros.

    ``rows`` : rows of blocks, each an expression, an unknown, an array, 0 or None.

    Raises ModelError: rows of different length; blocks that do not fit; a row or column of zeros,
    whose size is not known; None if the mirrored block is None too.
    """
    grid = [list(row) for row in rows]
    width = len(grid[0]) if grid else 0
    if not width or any(len(row) != width for row in grid):
        raise ModelError(
            f"block: rows of {[len(row) for row in grid]} blocks; rows of one length are needed"
        )
    entries: dict[tuple[int, int], Expression] = {}
    for i, row in enumerate(grid):
        for j, entry in enumerate(row):
            mirror = grid[j][i] if j < len(grid) and i < width else None
            if entry is None and (i == j or mirror is None):
                raise ModelError(
                    f"block: entry ({i + 1}, {j + 1}) is None, and so is its mirror image; give "
                    "one of the two, 0 for zeros"
                )
            if _zero(entry) or (entry is None and _zero(mirror)):
                continue
            entries[i, j] = expression_of(mirror).T if entry is None else expression_of(entry)
    heights = [_size(entries, i, 0, "row") for i in range(len(grid))]
    widths = [_size(entries, j, 1, "column") for j in range(width)]
    pieces: list[Piece] = []
    for (i, j), placed in entries.items():
        if placed.shape != (heights[i], widths[j]):
            raise ModelError(
                f"block: entry ({i + 1}, {j + 1}) is {placed.shape[0]} x {placed.shape[1]}; its "
                f"row and column make it {heights[i]} x {widths[j]}"
            )
        mirror = grid[i][j] is None
        pieces += [replace(piece, at=(i, j), mirror=mirror) for piece in placed.flat().pieces]
    return Expression(tuple(heights), tuple(widths), tuple(pieces))


def symmetric_block(
    sizes: Sequence[int], cells: Mapping[tuple[int, int], Expression]
) -> Expression:
    """Return the symmetric block matrix with these blocks and their mirror images, else zero.

    ``sizes`` : of the diagonal blocks.
    ``cells`` : (block row, block column) -> the block; the mirror image of one below the diagonal
    is added to the block above it.
    """
    pieces: list[Piece] = []
    for (i, j), cell in cells.items():
        pieces += [replace(piece, at=(i, j)) for piece in cell.flat().pieces]
        if i != j:
            mirrored = cell.flat().T.pieces
            pieces += [replace(piece, at=(j, i), mirror=True) for piece in mirrored]
    return Expression(tuple(sizes), tuple(sizes), tuple(pieces))


def _zero(entry: object) -> bool:
    return not isinstance(entry, Operators) and np.ndim(cast("float", entry)) == 0 and entry == 0


def _size(entries: dict[tuple[int, int], Expression], k: int, axis: int, owner: str) -> int:
    """Return the size of a block row or column; its mirror image has the same size."""
    sizes = [entry.shape[axis] for position, entry in entries.items() if position[axis] == k]
    sizes += [
        entry.shape[1 - axis] for position, entry in entries.items() if position[1 - axis] == k
    ]
    if not sizes:
        raise ModelError(
            f"block: {owner} {k + 1} has zeros alone, so its size is not known; give an array of "
            "zeros"
        )
    return sizes[0]
