r"""Structured gains in one convex step: M = K G with a slack matrix G that keeps the structure.

Let G_j be a matrix for each gain, M_j = K_j G_j, F_ij = A_i G_j - B_i M_j, and mu > 0 a number:

    continuous   [ 2 alpha Q + He(F_ij)   Q + mu F_ij - G_j'  ]
                 [ .                      -mu (G_j + G_j')    ]  < 0

    discrete     [ -rho^2 Q   F_ij               ]
                 [ .          Q - G_j - G_j'     ]  < 0,     rho = e^(-alpha T)

Q has no structure.  The first matrix is [2 alpha Q, Q; Q, 0] + He([N; -I] G_j [I, mu I]) with
N = A_i - B_i K_j; multiplication by [I, N] and its transpose gives He(N Q) + 2 alpha Q < 0.  In the
second, G Q^-1 G' >= G + G' - Q; a congruence with diag(I, G_j^-1) and a Schur complement give
N Q N' < rho^2 Q.  So both show the rate for V = x' Q^-1 x.  They are sufficient, but not necessary
for structured gains with a common Q: G_j must keep the pattern, and only a few values of mu are
tried.

Entry (a, b) of G_j is 0 if some input depends on a but not on b; then M_j G_j^-1 has the pattern of
M_j.

Source: de Oliveira, Bernussou, Geromel (1999), Systems & Control Letters 37, for discrete time;
Mozelli, Palhares, Avellar (2009), Information Sciences 179, for such G with a number mu.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import (
    corners_of,
    decay_parameter,
    input_stack,
    number,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import (
    Expression,
    He,
    block,
    matrix,
    placement,
)
from takagi.lmi.gains.decay.condition import Controlled, theta_weight
from takagi.lmi.gains.structured.structure import Structure, structure_of
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


def structured_pdc_condition(
    model: Controlled,
    pattern: ArrayLike | None = None,
    *,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    output: ArrayLike | None = None,
    shared: ArrayLike | None = None,
    mu: float = 1.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the module's double sum < 0 with 0 < Q <= I, a structured G_j and M_j = K_j G_j.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    pattern, output, shared, relaxation, sample_time : as for ``structured_pdc``.
    decay_rate : alpha in 1/s.
    mu : in s, positive; about the inverse of the size of the vertices.  Not in discrete time.

    Returns
    -------
    The condition.  With an output its states are [C; N] x, where N is orthonormal and C N' = 0;
    otherwise they are the model's.  The unknowns are ``Q``, a row ``Ga`` of G for each state, a row
    ``Fk`` of M for each input with a free entry, and those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : wrong shapes, entries that are not finite, an unknown relaxation, mu not positive.
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    alpha = float(number("decay_rate", decay_rate))
    mu = float(number("mu", mu))
    if mu <= 0:
        raise ModelError(f"mu is {mu:g} s; it must be positive")
    step = sample_time_of(model, sample_time)
    r, n, m = B.shape
    common = relaxation == "common-gain"
    structure = structure_of((r, n, m), pattern, output, np.zeros(r) if common else shared)
    return slack_condition(
        A, B, structure, relaxation, alpha=alpha, mu=mu, step=step, corners=corners_of(model)
    )


def slack_condition(
    A: Floats,
    B: Floats,
    structure: Structure,
    relaxation: str,
    *,
    alpha: float = 0.0,
    mu: float = 1.0,
    step: float | None = None,
    corners: Corners | None = None,
) -> Condition:
    """Return the condition of ``structured_pdc_condition`` for arguments that are checked."""
    n = A.shape[1]
    if not np.array_equal(structure.C, np.eye(n)):
        T = np.linalg.inv(_with_complement(structure.C))
        A, B = np.linalg.solve(T, A @ T), np.linalg.solve(T, B)
    Q = Unknown("Q", n, n, symmetric=True)
    rate, M = decay_parameter(alpha, step), structure.unknowns()
    slack_rows = tuple(
        Unknown(f"G{a + 1}", 1, int(row.sum()), count=structure.groups, latex=f"g_{{{a + 1}}}")
        for a, row in enumerate(structure.slack_pattern())
    )
    G_j = _by_rows(structure, slack_rows, structure.slack_pattern(), range(n), n)
    inputs, pattern = len(structure.pattern), np.zeros((len(structure.pattern), n), dtype=bool)
    pattern[:, : structure.pattern.shape[1]] = structure.pattern
    M_j = _by_rows(structure, M, pattern, structure.rows, inputs)
    F = matrix(A, "A_{i}", over="i") @ G_j - matrix(B, "B_{i}", over="i") @ M_j
    if step is None:
        m = matrix([[mu]], r"\mu")
        theta = block([[2 * rate * Q + He(F), Q + m * F - G_j.T], [None, -He(m * G_j)]])
    else:
        theta = block([[-rate * Q, F], [None, Q - He(G_j)]])
    statement = (theta << 0).named("", weight=theta_weight(A, alpha, step))
    loop = double_sum_of(statement, rules=len(A), corners=corners)
    slack, sums = relaxation_named(relaxation)(loop)
    return pose(
        positive_definite(Q),
        scale_bound(Q),
        *sums,
        unknowns=(Q, *slack_rows, *M, *slack),
        parameters=(rate,),
        name=f"structured gains with a slack matrix, {relaxation}",
        source="de Oliveira, Bernussou, Geromel (1999); Mozelli, Palhares, Avellar (2009)",
    )


def slack_gains(values: Mapping[str, Floats], structure: Structure) -> Floats:
    """Return F (groups, m, p) of K_j = M_j G_j^-1, with exact zeros off the pattern."""
    n = structure.C.shape[1]
    G = np.zeros((structure.groups, n, n))
    for a, measured in enumerate(structure.slack_pattern()):
        G[:, a, measured] = values[f"G{a + 1}"][:, 0]
    M = [values[row.name] for row in structure.unknowns()]
    row_gains: list[Floats] = []
    for k, row in zip(structure.rows, M, strict=True):
        measured = np.flatnonzero(structure.pattern[k])
        inside = G[:, measured[:, None], measured]
        K = np.linalg.solve(inside.transpose(0, 2, 1), row.transpose(0, 2, 1))
        row_gains.append(np.asarray(K.transpose(0, 2, 1), dtype=np.float64))
    return structure.assembled(row_gains)


def _by_rows(
    structure: Structure,
    unknowns: Sequence[Unknown],
    pattern: Array,
    rows: Iterable[int],
    height: int,
) -> Expression:
    """Return the matrix of a gain whose rows are unknown where the pattern is True, else zero."""
    columns, eye, summands = np.eye(height), np.eye(pattern.shape[1]), []
    for k, unknown in zip(rows, unknowns, strict=True):
        free = eye[pattern[k]]
        place = placement(free) if pattern[k].all() else matrix(free, f"S_{{{unknown.name}}}")
        summands.append(
            matrix(columns[:, [k]], f"e_{{{k + 1}}}") @ structure.of_gain(unknown) @ place
        )
    return sum(summands[1:], summands[0])


def _with_complement(C: Floats) -> Floats:
    """Return [C; N], N an orthonormal basis of the null space of C."""
    _, _, right_vectors = np.linalg.svd(C)
    return np.concatenate([C, right_vectors[len(C) :]])
