r"""The determinant of a symmetric matrix, to be maximised, as LMIs.

log det X is concave, and its greatest value is where det(X)^(1/n) is greatest:

    v <= (z_1 ... z_n)^(1/n),    [[X, T], [T', diag(z)]] >= 0,

with T lower triangular and z its diagonal; then det X >= z_1 ... z_n, with equality attained.  The
geometric mean is a tree of [[a, c], [c, b]] >= 0, c^2 <= a b, whose leaves are z_1, ..., z_n and,
up to a power of two, its root itself.

Source: Ben-Tal and Nemirovski (2001), Lectures on Modern Convex Optimization, section 4.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.expressions.expression import (
    Expression,
    Inequality,
    added,
    block,
    expression_of,
    placement,
)
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False)
class LogDet:
    """sign times log det X; of a condition it is the whole objective.

    Attributes
    ----------
    X : (n, n), symmetric.
    sign : 1, or -1 for ``-log_det(X)``.
    """

    X: Expression
    sign: int = 1

    def __neg__(self) -> LogDet:
        return LogDet(self.X, -self.sign)


def log_det(value: object) -> LogDet:
    """Return log det X, for ``pose(maximise=log_det(P))``; the objective is then -det(P)^(1/n).

    Raises
    ------
    ModelError : several matrices, or one that is not square.
    """
    X = expression_of(value).flat()
    if X.shape[0] != X.shape[1] or X.count > 1:
        raise ModelError(f"log_det of {X!r}; one square matrix is needed")
    return LogDet(X)


def root_of_determinant(
    X: Expression, prefix: str = ""
) -> tuple[Expression, tuple[Unknown, ...], tuple[Inequality, ...]]:
    """Return v, its unknowns and the module's inequalities, which say v <= det(X)^(1/n).

    ``prefix`` : of the names of unknowns and inequalities.
    """
    n = X.shape[0]
    if n == 1:
        return X, (), ()
    v = Unknown(f"{prefix}volume", 1, 1, latex="v")
    # The tree's nodes, the root first, then its leaves: children of node k are 2 k and 2 k + 1.
    nodes = 2 ** int(np.ceil(np.log2(n))) - 1
    c = Unknown(f"{prefix}means", 1, 1, count=nodes + n, latex="c")
    T = Unknown(f"{prefix}factor", 1, 1, count=triangle(n - 1), latex="T")
    dots = ", " if n == 2 else r", \dots, "
    missing = "" if nodes + 1 == n else rf",\; c_l = c_1 \text{{ for }} l > {c.count}"
    statements = (
        _factor(X, T, c).named(f"{prefix}factor", rf"z = (c_{{{nodes + 1}}}{dots}c_{{{c.count}}})"),
        _means(c, nodes).named(f"{prefix}geometric mean", rf"k = 1, \dots, {nodes}{missing}"),
        (c.member(0) - v >= 0).named(f"{prefix}volume"),
    )
    return v.as_expression(), (v, c, T), statements


def _factor(X: Expression, T: Unknown, c: Unknown) -> Inequality:
    """Pose [[X, T], [T', z]] >= 0: T lower triangular, z its diagonal, the leaves of the tree."""
    n, eye = X.shape[0], np.eye(X.shape[0])
    row, column = np.tril_indices(n, -1)
    entries = T.members(np.arange(len(row)), r"T_{\text{lower}}")
    lower = added(entries * placement(eye[row][:, :, None] * eye[column][:, None, :]), latex="")
    z_entries = c.members(np.arange(c.count - n, c.count), r"\mathrm{diag}(z)")
    z = added(z_entries * placement(eye[:, :, None] * eye[:, None, :]), latex="")
    return block([[X, lower + z], [None, z]]) >= 0


def _means(c: Unknown, nodes: int) -> Inequality:
    """Pose [[c_2k, c_k], [c_k, c_2k+1]] >= 0 at every node; the root again for missing leaves."""
    k = np.arange(1, nodes + 1)

    def means(index: Indices, symbol: str) -> Expression:
        return c.members(np.where(index <= c.count, index, 1) - 1, symbol)

    rows = [[means(2 * k, "c_{2k}"), means(k, "c_k")], [None, means(2 * k + 1, "c_{2k+1}")]]
    return block(rows) >= 0
