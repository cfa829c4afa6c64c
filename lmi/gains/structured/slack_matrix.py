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

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import (
    corners_of,
    input_stack,
    number,
    rate_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import Array, Condition, Position, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.decay.condition import Controlled, theta_weight
from takagi.lmi.gains.structured.structure import Structure, structure_of
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum, SumPart
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
    G, M = _rows("G", structure.slack_pattern(), structure), structure.unknowns()
    forms = _continuous(Q) if step is None else _discrete(Q)
    loop = DoubleSum(
        rules=len(A),
        blocks=(n, n),
        parts=(*forms, *_moved(A, B, G, M, structure, mu, step), *_own(G, structure, mu, step)),
        weight=theta_weight(A, alpha, step),
        corners=corners,
    )
    slack, sums = relaxation_named(relaxation)(loop)
    return Condition(
        name=f"structured gains with a slack matrix, {relaxation}",
        unknowns=(Q, *(row for row, _, _ in G), *M, *slack),
        lmis=(positive(Q), bounded(Q), *sums),
        parameters=rate_parameter(alpha, step),
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


# An unknown row, the number of the row, and (columns, n) that puts its entries in their places.
_Row = tuple[Unknown, int, Array]


def _rows(name: str, pattern: Array, structure: Structure) -> list[_Row]:
    eye = np.eye(len(pattern))
    return [
        (
            Unknown(
                f"{name}{a + 1}",
                1,
                int(measured.sum()),
                count=structure.groups,
                latex=f"{name.lower()}_{{{a + 1}}}",
            ),
            a,
            eye[measured],
        )
        for a, measured in enumerate(pattern)
    ]


def _moved(
    A: Array,
    B: Array,
    G: list[_Row],
    M: tuple[Unknown, ...],
    structure: Structure,
    mu: float,
    step: float | None,
) -> list[SumPart]:
    """Return the parts with F_ij: He(F_ij) and mu F_ij in continuous time, F_ij in discrete."""
    n = A.shape[1]
    unit_rows = np.eye(n)
    rows = [(row, A[:, :, [a]], selector, f"A_{{i}} e_{{{a + 1}}}") for row, a, selector in G]
    for k, row in zip(structure.rows, M, strict=True):
        measured = np.flatnonzero(structure.pattern[k])
        rows.append((row, -B[:, :, [k]], unit_rows[measured], f"-B_{{i}} e_{{{k + 1}}}"))
    where: list[tuple[Position, float, str]] = [((0, 1), 1.0, "")]
    if step is None:
        where = [((0, 0), 1.0, ""), ((0, 1), mu, r"\mu ")]
    return [
        SumPart(
            unknown=row,
            left=factor * column,
            right=selector[None],
            at=at,
            plus_transpose=at == (0, 0),
            member=structure.member,
            latex=(_times(letter, text), _placed(selector, row)),
            symbol=_of_gain(row),
        )
        for row, column, selector, text in rows
        for at, factor, letter in where
    ]


def _own(G: list[_Row], structure: Structure, mu: float, step: float | None) -> list[SumPart]:
    """Return the parts with G_j alone: -G_j' and -mu (G_j + G_j'); in discrete time -G_j - G_j'."""
    n = len(G)
    where: list[tuple[Position, float, str]] = [((1, 1), -1.0, "")]
    if step is None:
        where = [((1, 0), -1.0, ""), ((1, 1), -mu, r"\mu ")]
    return [
        SumPart(
            unknown=row,
            left=factor * np.eye(n)[:, [a]][None],
            right=selector[None],
            at=at,
            plus_transpose=at == (1, 1),
            member=structure.member,
            latex=(_times(letter, f"-e_{{{a + 1}}}"), _placed(selector, row)),
            symbol=_of_gain(row),
        )
        for row, a, selector in G
        for at, factor, letter in where
    ]


def _times(letter: str, text: str) -> str:
    """Return the product of two formulas, with a minus sign moved to the front."""
    return f"-{letter}{text[1:]}" if text.startswith("-") else f"{letter}{text}"


def _placed(selector: Array, row: Unknown) -> str:
    """Return the factor S after a row, which puts its entries in their columns; else nothing."""
    return "" if selector.shape[0] == selector.shape[1] else f"S_{{{row.name}}}"


def _of_gain(row: Unknown) -> str:
    """Return a row's symbol with the index of the gain, where there is more than one."""
    return row.symbol if row.count == 1 else row.symbol.removesuffix("}") + "{j}}"


def _continuous(Q: Unknown) -> tuple[SumPart, ...]:
    eye = np.eye(Q.rows)[None]
    return (
        SumPart(unknown=Q, left=2.0 * eye, right=eye, parameter="alpha", latex=(r"2\alpha", "")),
        SumPart(unknown=Q, left=eye, right=eye, at=(0, 1)),
    )


def _discrete(Q: Unknown) -> tuple[SumPart, ...]:
    eye = np.eye(Q.rows)[None]
    return (
        SumPart(unknown=Q, left=-eye, right=eye, parameter="contraction", latex=(r"-\rho^2", "")),
        SumPart(unknown=Q, left=eye, right=eye, at=(1, 1)),
    )


def _with_complement(C: Floats) -> Floats:
    """Return [C; N], N an orthonormal basis of the null space of C."""
    _, _, right_vectors = np.linalg.svd(C)
    return np.concatenate([C, right_vectors[len(C) :]])
