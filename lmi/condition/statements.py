"""From statements that were written with operators to a condition as data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from takagi.lmi.condition.log_det import LogDet, root_of_determinant
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Equality, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import (
    Equation,
    Expression,
    Inequality,
    Parameter,
    expression_of,
    matrix,
    pieces_at,
)
from takagi.lmi.expressions.piece import (
    Letter,
    NamedNumber,
    Piece,
    is_identity,
    number_text,
    turned,
)
from takagi.models.errors import ModelError

Statement: TypeAlias = Inequality | Equation
# What the functions that solve or show a condition take.
StatedCondition: TypeAlias = Condition | Statement | Sequence[Statement]
# Entries above and below the diagonal that differ by no more than rounding, relative.
ROUNDED = 1e-11


def pose(
    *statements: Statement | LMI,
    minimise: object = None,
    maximise: object = None,
    unknowns: Sequence[Unknown] = (),
    parameters: Sequence[Parameter] = (),
    name: str = "a condition of one's own",
    source: str = "",
) -> Condition:
    """Return the condition that all statements hold, and the objective, if given, is least.

    Parameters
    ----------
    statements : comparisons of expressions: ``X << Y`` and ``X >> Y`` (definite, with a margin),
        ``X <= Y`` and ``X >= Y`` (semidefinite), ``X == Y``; ``.named("...")`` names one. An
        ``LMI``, as from ``lmi_of``, is taken as it is.
    minimise : a 1 x 1 expression that is linear in the unknowns, e.g. ``trace(P)`` or ``gamma``.
    maximise : the same as minimising its negative, which is what ``objective`` then is of; or
        ``log_det(P)``, for which -det(P)^(1/n) is minimised.
    unknowns : those that come first among the solver's variables; the others follow as written.
    parameters : values of those that stand in an ``LMI``; statements bring their own.
    name, source : of the condition.

    Returns
    -------
    The condition as data; nothing is solved.  ``decide`` and ``optimise`` solve it, ``latex``
    writes it, ``expressed`` passes it to cvxpy, ``exact_solution`` decides an answer exactly.

    Raises
    ------
    ModelError : no statement, another value than a statement, an inequality of a matrix that is not
        symmetric, unknowns of one name that differ, an objective with a constant, two objectives.
    """
    if not statements:
        raise ModelError("pose: no statement was given; give at least one, e.g. P >> 0")
    goal, roots = _goal(minimise, maximise)
    lmis: list[LMI] = []
    equalities: list[Equality] = []
    statements = (*statements, *roots)
    for number, statement in enumerate(statements, start=1):
        if isinstance(statement, LMI):
            lmis.append(statement)
        elif isinstance(statement, Inequality):
            lmis.append(lmi_of(statement, f"inequality {number}"))
        elif isinstance(statement, Equation):
            equalities.append(_equality(statement, statement.name or f"equality {number}"))
        else:
            raise ModelError(
                f"pose: statement {number} is {statement!r}; a comparison of expressions is "
                "needed, e.g. He(P @ A) << 0 or P @ B == C.T"
            )
    values = {parameter.name: float(parameter.value) for parameter in parameters}
    named = {unknown.name: unknown for unknown in unknowns}
    for stated in (*statements, goal):
        for unknown in _unknowns(stated):
            if named.setdefault(unknown.name, unknown) != unknown:
                raise ModelError(
                    f"pose: two unknowns have the name {unknown.name} and are not alike; rename one"
                )
        for symbol in _parameters(stated):
            if values.setdefault(symbol.name, float(symbol.value)) != float(symbol.value):
                raise ModelError(
                    f"pose: the parameter {symbol.name} has two values, {values[symbol.name]:g} "
                    f"and {float(symbol.value):g}; give one"
                )
    return Condition(
        name=name,
        unknowns=tuple(named.values()),
        lmis=tuple(lmis),
        equalities=tuple(equalities),
        objective={} if goal is None else _objective(goal),
        parameters=values,
        source=source,
    )


def _goal(minimise: object, maximise: object) -> tuple[Expression | None, tuple[Inequality, ...]]:
    """Return what is minimised, and the inequalities that it needs."""
    if minimise is not None and maximise is not None:
        raise ModelError("pose: minimise and maximise; give one, the other as an inequality")
    if isinstance(maximise, LogDet):
        minimise, maximise = -maximise, None
    if isinstance(minimise, LogDet):
        if minimise.sign > 0:
            raise ModelError(
                "pose: log_det is concave, so it can be maximised only: maximise=log_det(P)"
            )
        v, _, statements = root_of_determinant(minimise.X, "log det, ")
        return -v, statements
    if maximise is not None:
        return -expression_of(maximise, "the objective"), ()
    return None if minimise is None else expression_of(minimise, "the objective"), ()


def condition_of(statements: StatedCondition, caller: str) -> Condition:
    """Return a condition, or that of one statement or of several in a list.

    Raises
    ------
    ModelError : anything else.
    """
    if isinstance(statements, Condition):
        return statements
    if isinstance(statements, (Inequality, Equation)):
        return pose(statements)
    if isinstance(statements, Sequence) and not isinstance(statements, str):
        return pose(*statements)
    raise ModelError(
        f"{caller} of {statements!r}; a condition is needed, pose(P >> 0, He(P @ A) << 0) or one "
        "of the functions named ..._condition, or a list of statements"
    )


def _unknowns(stated: Statement | LMI | Expression | None) -> Iterator[Unknown]:
    if isinstance(stated, LMI):
        yield from (term.unknown for term in stated.terms)
        return
    for piece in _pieces(stated):
        if piece.unknown is not None:
            assert isinstance(piece.unknown, Unknown)  # no other class is one
            yield piece.unknown


def _parameters(stated: Statement | LMI | Expression | None) -> Iterator[NamedNumber]:
    if not isinstance(stated, LMI):
        yield from (piece.parameter for piece in _pieces(stated) if piece.parameter is not None)


def _pieces(stated: Statement | Expression | None) -> tuple[Piece, ...]:
    if stated is None:
        return ()
    return (stated if isinstance(stated, Expression) else stated.expression).pieces


def lmi_of(statement: Inequality, name: str = "inequality") -> LMI:
    r"""Return an inequality as data, e.g. of ``(He(P @ A) << 0).named("vertex", weight=2.0)``.

    ``name`` : where the inequality has none.

    Raises ModelError: a matrix that is not square or not symmetric, or without an unknown.
    """
    name = statement.name or name
    expression = statement.expression
    if expression.shape[0] != expression.shape[1]:
        raise ModelError(
            f"{name}: {expression.shape[0]} x {expression.shape[1]}; a square matrix is needed"
        )
    if expression.known:
        raise ModelError(f"{name}: no unknown is in it; leave it out")
    if expression.rows != expression.columns:
        expression = expression.flat()
    if len(expression.lead) > 1:
        raise ModelError(f"{name}: it has two rules i, j; give it to double_sum_of")
    if not _mirrored(expression):
        _check_symmetric(expression, name)
    summands = [_lowered(*summand) for summand in symmetric_summands(expression)]
    return LMI(
        name=name,
        blocks=expression.rows,
        terms=tuple(summand for summand in summands if isinstance(summand, Term)),
        constants=tuple(summand for summand in summands if isinstance(summand, Constant)),
        sign=statement.sign,
        count=expression.count,
        weight=statement.weight,
        strict=statement.strict,
        labels=statement.labels,
        index=statement.index or _counted(expression.count),
    )


def whole_terms(expression: Expression) -> tuple[Term, ...]:
    """Return a symmetric matrix of unknowns as terms on the whole of an LMI."""
    summands = (_lowered(*summand) for summand in symmetric_summands(expression))
    return tuple(replace(term, at=None) for term in summands if isinstance(term, Term))


def positive_definite(P: Unknown) -> Inequality:
    """Pose P > 0."""
    return (P >> 0).named(f"{P.name} positive definite")


def scale_bound(P: Unknown, largest: float = 1.0, *, latex: str = "") -> Inequality:
    """Pose P <= largest I, which fixes the scale of a condition that is homogeneous in P.

    ``latex`` : the bound; empty for I, or I times the number.
    """
    bound = largest * np.eye(P.rows)
    return (P <= (matrix(bound, latex) if latex else bound)).named(f"scale of {P.name}")


def symmetric_summands(expression: Expression) -> Iterator[tuple[Piece, bool]]:
    """Yield the pieces on and above the diagonal, each with whether its transpose is added.

    A transposed unknown above the diagonal is written as its mirror image below it, and so is what
    ``block`` was given below it.
    """
    for j in range(len(expression.rows)):
        for i in range(j):
            for piece in pieces_at(expression, (i, j)):
                turns = piece.mirror and (piece.unknown is None or not piece.T.transposed)
                yield piece.T if turns or piece.transposed else piece, False
        yield from _diagonal(list(pieces_at(expression, (j, j))))
    yield from _diagonal(list(pieces_at(expression, None)))


def _equality(statement: Equation, name: str) -> Equality:
    expression = statement.expression.flat()
    if expression.known:
        raise ModelError(f"{name}: no unknown is in it; leave it out")
    pieces = [replace(piece, at=(0, 1)) for piece in expression.pieces]
    lowered = [_lowered(piece.T if piece.transposed else piece) for piece in pieces]
    return Equality(
        name=name,
        shape=expression.shape,
        terms=tuple(summand for summand in lowered if isinstance(summand, Term)),
        constants=tuple(summand for summand in lowered if isinstance(summand, Constant)),
        count=expression.count,
        index=statement.index or _counted(expression.count),
    )


def _counted(count: int) -> str:
    return "" if count == 1 else rf"i = 1, \dots, {count}"


def _diagonal(pieces: list[Piece]) -> Iterator[tuple[Piece, bool]]:
    """Yield the pieces of a diagonal block: each with its transpose, or half of each twice."""
    remaining = list(pieces)
    while remaining:
        piece = remaining.pop(0)
        if piece.unknown is None:
            # The whole is symmetric, so the symmetric parts of its constants add up to the same.
            symmetric = bool(np.all(piece.left == turned(piece.left)))
            twin = None if symmetric else _twin(piece, remaining)
            if symmetric:
                yield piece, False
            elif twin is not None:
                remaining.remove(twin)
                symmetrised = replace(piece, left=piece.left + turned(piece.left))
                yield replace(symmetrised, before=(_he(piece.before),)), False
            else:
                half = piece.times(Fraction(1, 2) if _exact(piece) else 0.5)
                yield replace(half, left=half.left + turned(half.left)), False
        elif (twin := _twin(piece, remaining)) is not None:
            remaining.remove(twin)
            yield piece.T if piece.transposed else piece, True
        elif _is_multiple(piece) or _alike(piece, piece.T):
            yield piece, False
        else:
            half = piece.times(Fraction(1, 2) if _exact(piece) else 0.5)
            yield half.T if half.transposed else half, True


def _is_multiple(piece: Piece) -> bool:
    """Return whether it is a number times a symmetric unknown, or one of 1 x 1."""
    assert piece.unknown is not None
    return (piece.unknown.symmetric or piece.unknown.scalar) and all(
        is_identity(array)
        or array.shape[-1] == array.shape[-2]
        and np.array_equal(array, array[..., :1, :1] * np.eye(array.shape[-1], dtype=np.intp))
        for array in (piece.left, piece.right)
        if array is not None
    )


def _exact(piece: Piece) -> bool:
    return piece.left.dtype == object


def _he(word: tuple[Letter, ...]) -> Letter:
    return Letter(rf"\mathrm{{He}}({' '.join(letter.text for letter in word)})", symmetric=True)


def _mirrored(expression: Expression) -> bool:
    """Return whether the matrix is symmetric piece by piece, which needs no numbers."""
    size = len(expression.rows)
    corners = [(i, j) for j in range(size) for i in range(j)]
    for i, j in corners:
        lower = list(pieces_at(expression, (j, i)))
        for piece in pieces_at(expression, (i, j)):
            twin = _twin(piece, lower)
            if twin is None:
                return False
            lower.remove(twin)
        if lower:
            return False
    for at in (None, *((k, k) for k in range(size))):
        remaining = list(pieces_at(expression, at))
        while remaining:
            piece = remaining.pop(0)
            twin = _twin(piece, remaining)
            if twin is not None:
                remaining.remove(twin)
            elif not _is_symmetric(piece):
                return False
    return True


def _is_symmetric(piece: Piece) -> bool:
    if piece.unknown is None:
        return bool(np.all(piece.left == turned(piece.left)))
    return _is_multiple(piece) or _alike(piece, piece.T)


def _twin(piece: Piece, candidates: list[Piece]) -> Piece | None:
    """Return the piece among the others that is this one's transpose, number by number."""
    if not candidates:
        return None
    turned = piece.T
    return next((candidate for candidate in candidates if _alike(candidate, turned)), None)


def _alike(first: Piece, second: Piece) -> bool:
    if (
        first.transposed != second.transposed
        or first.factor != second.factor
        or first.item_count != second.item_count
        or first.parameter != second.parameter
        or (first.unknown is None) != (second.unknown is None)
        or first.unknown != second.unknown
    ):
        return False
    pairs = (
        (first.items, second.items),
        (first.left, second.left),
        (first.right, second.right),
        (first.members, second.members),
    )
    return all(
        a is b or (a is not None and b is not None and np.array_equal(a, b)) for a, b in pairs
    )


def _lowered(piece: Piece, plus_transpose: bool = False) -> Term | Constant:
    sign, factor, before, behind = printed_factors(piece)
    if piece.unknown is None:
        if piece.items is not None:
            raise ModelError("a sum has a known matrix; add it up beforehand")
        if piece.parameter is not None:
            raise ModelError(
                f"the parameter {piece.parameter.name} multiplies a known matrix alone; it can "
                "multiply an unknown: introduce an unknown for the product, or give its value"
            )
        identity = "" if before else ("1" if piece.shape == (1, 1) else "I")
        return Constant(
            value=piece.scaled_left(),
            at=piece.at,
            latex=_signed(sign, _joined(factor, before or identity)),
        )
    assert isinstance(piece.unknown, Unknown)  # no other class is one
    return Term(
        unknown=piece.unknown,
        left=piece.scaled_left(),
        right=piece.right,
        at=piece.at,
        plus_transpose=plus_transpose,
        items=piece.items,
        members=piece.members,
        parameter=None if piece.parameter is None else piece.parameter.name,
        latex=(_joined(sign, before), behind),
        symbol=piece.symbol or _member_symbol(piece, piece.unknown),
        factor=_joined(piece.sums, factor),
    )


def printed_factors(piece: Piece) -> tuple[str, str, str, str]:
    """Return the sign, the number, and the symbols before and behind the unknown."""
    sign = "-" if piece.factor < 0 else ""
    size = piece.factor if piece.factor >= 0 else -piece.factor
    factor = "" if size == 1 else number_text(size)
    before = " ".join(letter.text for letter in piece.before)
    behind = " ".join(letter.text for letter in piece.behind)
    return sign, factor, before, behind


def _signed(sign: str, text: str) -> str:
    if sign and text.startswith("-"):
        return text[1:].lstrip()
    return sign + text


def _joined(*texts: str) -> str:
    nonempty = [text for text in texts if text]
    if len(nonempty) == 2 and nonempty[1] == "1":
        return nonempty[0]
    return " ".join(nonempty)


def _member_symbol(piece: Piece, unknown: Unknown) -> str:
    if unknown.count == 1 or piece.members is None:
        return ""
    index = "i" if len(piece.members) > 1 else str(int(piece.members[0]) + 1)
    return f"{unknown.symbol}_{{{index}}}"


def _check_symmetric(expression: Expression, name: str) -> None:
    """Raise unless the matrix is symmetric for all values: at two draws, to within rounding."""
    random = np.random.default_rng(1)
    unknowns = {unknown.name: unknown for unknown in _unknowns(expression)}
    count, rows, columns = expression.count, expression.rows, expression.columns
    for _ in range(2):
        values = {
            key: unknown.value(random.uniform(0.5, 2.0, unknown.length))
            for key, unknown in unknowns.items()
        }
        total = np.zeros((count, *expression.shape))
        size = np.zeros(total.shape)
        for piece in expression.pieces:
            block_slices = slice(None), slice(None), slice(None)
            if piece.at is not None:
                i, j = piece.at
                block_slices = (
                    slice(None),
                    slice(sum(rows[:i]), sum(rows[: i + 1])),
                    slice(sum(columns[:j]), sum(columns[: j + 1])),
                )
            block = piece.value(values, count)
            total[block_slices] += block
            size[block_slices] += np.abs(block).max(axis=(1, 2), keepdims=True)
        size = size + size.transpose(0, 2, 1)
        gap = np.abs(total - total.transpose(0, 2, 1))
        if np.any(gap > ROUNDED * size):
            item, row, column = (int(k) for k in np.argwhere(gap > ROUNDED * size)[0])
            raise ModelError(
                f"{name}: item {item + 1} of {count} is not symmetric: entries [{row}, {column}] "
                f"and [{column}, {row}] differ; write He(...) for X + X', and None in block() "
                "for the mirror image of a block"
            )


def _objective(goal: Expression) -> dict[str, Array]:
    """Return unknown name -> weights of its entries."""
    if goal.shape != (1, 1) or goal.count != 1:
        raise ModelError(
            f"the objective is {goal.count} matrices of {goal.shape[0]} x {goal.shape[1]}; one "
            "1 x 1 expression is needed, e.g. trace(P)"
        )
    costs: dict[str, Array] = {}
    for piece in goal.pieces:
        if piece.parameter is not None:
            raise ModelError(
                f"the objective has the parameter {piece.parameter.name}; give its value"
            )
        if piece.unknown is None:
            raise ModelError(
                "the objective has a constant; leave it out, it does not move the minimum"
            )
        unknown = piece.unknown
        assert isinstance(unknown, Unknown)  # no other class is one
        cost = costs.setdefault(unknown.name, np.zeros((unknown.count, unknown.rows, unknown.cols)))
        right = np.eye(1)[None] if piece.right is None else piece.right.astype(np.float64)
        left = piece.scaled_left().astype(np.float64)
        weight = left.transpose(0, 2, 1) @ right.transpose(0, 2, 1)
        weight = weight.transpose(0, 2, 1) if piece.transposed else weight
        np.add.at(cost, np.zeros(1, int) if piece.members is None else piece.members, weight)
    if not costs:
        raise ModelError("the objective has no unknown; leave it out")
    return costs
