"""Functions that make expressions: He, block matrices, traces, known matrices with a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from takagi.lmi.expressions.constant_data import Letter, data_stack
from takagi.lmi.expressions.expression import Expression, Operators, expression_of
from takagi.lmi.expressions.piece import Piece
from takagi.models.errors import ModelError


def matrix(value: object, latex: str) -> Expression:
    r"""Return a known matrix that formulas show by a symbol, e.g. ``matrix(A, "A_i")``.

    Parameters
    ----------
    value : (p, q), or (N, p, q) for one matrix a vertex; Fractions and decimal strings stay exact.
    latex : the symbol.

    Raises
    ------
    ModelError : not a matrix of finite numbers, or an empty symbol.
    """
    if not latex.strip():
        raise ModelError("matrix: the symbol is empty; give one, or use the array itself")
    array = data_stack(value, f"matrix {latex}")
    symmetric = array.shape[1] == array.shape[2] and bool(np.all(array == array.transpose(0, 2, 1)))
    piece = Piece(unknown=None, left=array, before=(Letter(latex, symmetric),))
    return Expression((array.shape[1],), (array.shape[2],), (piece,))


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
            column = Piece(unknown=None, left=row.transpose(0, 2, 1))
            found = piece.before_it(e).behind_it(column)
            if found.left.any() and (found.right is None or found.right.any()):
                pieces.append(found)
    return Expression((1,), (1,), tuple(pieces))


def block(rows: Sequence[Sequence[object]]) -> Expression:
    """Return a block matrix; None stands for the transpose of the mirrored block, 0 for zeros.

    Parameters
    ----------
    rows : rows of blocks, each an expression, an unknown, an array, 0 or None.

    Raises
    ------
    ModelError : rows of different length; blocks that do not fit; a row or column of zeros, whose
        size is not known; None if the mirrored block is None too.
    """
    grid = [list(row) for row in rows]
    width = len(grid[0]) if grid else 0
    if not width or any(len(row) != width for row in grid):
        raise ModelError(
            f"block: rows of {[len(row) for row in grid]} blocks; rows of one length are needed"
        )
    found: dict[tuple[int, int], Expression] = {}
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
            found[i, j] = expression_of(mirror).T if entry is None else expression_of(entry)
    heights = [_size(found, i, 0, "row") for i in range(len(grid))]
    widths = [_size(found, j, 1, "column") for j in range(width)]
    pieces: list[Piece] = []
    for (i, j), part in found.items():
        if part.shape != (heights[i], widths[j]):
            raise ModelError(
                f"block: entry ({i + 1}, {j + 1}) is {part.shape[0]} x {part.shape[1]}; its row "
                f"and column make it {heights[i]} x {widths[j]}"
            )
        pieces += [replace(piece, at=(i, j)) for piece in part.flat().pieces]
    return Expression(tuple(heights), tuple(widths), tuple(pieces))


def _zero(entry: object) -> bool:
    return not isinstance(entry, Operators) and np.ndim(cast("float", entry)) == 0 and entry == 0


def _size(found: dict[tuple[int, int], Expression], k: int, axis: int, what: str) -> int:
    """Return the size of a block row or column; its mirror image has the same size."""
    sizes = [part.shape[axis] for place, part in found.items() if place[axis] == k]
    sizes += [part.shape[1 - axis] for place, part in found.items() if place[1 - axis] == k]
    if not sizes:
        raise ModelError(
            f"block: {what} {k + 1} has zeros alone, so its size is not known; give an array of "
            "zeros"
        )
    return sizes[0]
