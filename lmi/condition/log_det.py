r"""log det X as an objective to be maximised, by LMIs: the geometric mean of the eigenvalues.

log det X is concave, and its greatest value is where det(X)^(1/n) is greatest.  With a lower
triangular Z, t <= det(X)^(1/n) holds exactly where

    [ X    Z       ]
    [ Z'   diag Z  ]  >= 0,      t <= (Z_11 ... Z_nn)^(1/n),

and the mean is a tree of [[a, w], [w, b]] >= 0, which say w^2 <= a b; t itself fills it up to a
power of two leaves.

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
    matrix,
)
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


def root_of_determinant(X: Expression) -> tuple[Unknown, tuple[Inequality, ...]]:
    """Return t and the module's inequalities, which say t <= det(X)^(1/n)."""
    n = X.shape[0]
    z, t = (
        Unknown("log det, z", 1, 1, count=triangle(n), latex="z"),
        Unknown("log det, t", 1, 1, latex="t"),
    )
    row, column = np.tril_indices(n)
    E = np.eye(n)[row][:, :, None] * np.eye(n)[column][:, None, :]
    on = np.flatnonzero(row == column)
    Z, diagonal = (
        added(z.members(k, "z_{k}") * matrix(E[k], "E_{k}"), latex=r"\sum_k")
        for k in (np.arange(len(row)), on)
    )
    leaves = [z.member(int(k)) for k in on]
    leaves += [t.as_expression()] * (2 ** max(1, (n - 1).bit_length()) - n)
    statements = [(block([[X, Z], [None, diagonal]]) >= 0).named("log det, triangle")]
    while len(leaves) > 1:
        pairs = list(zip(leaves[::2], leaves[1::2], strict=True))
        names = [f"log det, mean {len(pairs)}.{k + 1}" for k in range(len(pairs))]
        means = [t if len(pairs) == 1 else Unknown(name, 1, 1, latex="w") for name in names]
        statements += [
            (block([[a, mean], [None, b]]) >= 0).named(name)
            for (a, b), mean, name in zip(pairs, means, names, strict=True)
        ]
        leaves = [mean.as_expression() for mean in means]
    return t, tuple(statements)
