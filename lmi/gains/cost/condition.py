r"""The LMIs of guaranteed quadratic cost under parallel distributed compensation.

With S = P^-1, M_j = K_j S, u = -sum_j h_j K_j x, weights Q = F' F and R = G' G,

    Theta_ij = [ He(A_i S - B_i M_j)   S F'   M_j' G' ]
               [ F S                   -I     0       ],     sum_ij h_i h_j Theta_ij < 0,
               [ G M_j                 0      -I      ]

gives V' <= -(x' Q x + u' R u) for V = x' P x, so the cost is at most x(0)' P x(0); and
[[W, L'], [L, S]] > 0 gives trace W > trace L' P L, its mean where x(0) has the covariance L L'.

In discrete time, x+ = x + (N x + B u), N = A - I, the cost being the sum of x' Q x + u' R u,

    Theta_ij = [ He(N_i S - B_i M_j) / e   *    *    *  ]
               [ (N_i S - B_i M_j) / r     -S   0    0  ]
               [ F S / r                   0    -I   0  ],     r^2 = e > 0 any number,
               [ G M_j / r                 0    0    -I ]

gives V+ - V <= -(x' Q x + u' R u).  It is a congruence, with [I / r, I / r; 0, I] in the first two
rows, of the form with -S and A_i S - B_i M_j.  With e about the size of N, what happens in one
step, a model sampled ever faster gives the LMI of continuous time, not that of N = 0.

Source: Tanaka and Wang (2001), chapter 6; Boyd, El Ghaoui, Feron, Balakrishnan (1994), section
7.4.1, for one gain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import (
    corners_of,
    input_stack,
    positive_vector,
    sample_time_of,
    symmetric,
    vertex_stack,
)
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term, bounded
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.requirements.closed_loop import (
    closed_loop,
    gain_member,
    gain_symbol,
    gain_unknown,
)
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum, KnownBlock, SumPart
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.errors import ModelError

# Largest S in states where P is about 1: keeps S finite where a state costs nothing, at a cost of
# this much of the cost.
LARGEST_S = 1e6


def _cost_loop(
    A: Array, B: Array, F: Array, G: Array, S: Unknown, M: Unknown, corners: Corners | None
) -> DoubleSum:
    """Return the module's double sum: the closed loop, with the cost's factors below it."""
    n, m, q = S.rows, M.rows, len(F)
    plain = closed_loop(A, B, S, M, weight=1.0, corners=corners)
    # Without a decay rate: the cost says how fast.
    return DoubleSum(
        rules=len(A),
        blocks=(n, q, m),
        parts=(*plain.parts[:2], *_spent(F, G, S, M, 1, ("", ""))),
        fixed=_ones((q, m), 1),
        corners=corners,
    )


def _sampled_cost_loop(
    A: Array,
    B: Array,
    F: Array,
    G: Array,
    S: Unknown,
    M: Unknown,
    corners: Corners | None,
    span: float,
) -> DoubleSum:
    """Return the module's double sum in discrete time; ``span`` is e."""
    n, m, q = S.rows, M.rows, len(F)
    root = float(np.sqrt(span))
    plain = closed_loop(motion(A, 1.0), B, S, M, weight=1.0, corners=corners)
    loop = [replace(part, latex=_named(part.latex)) for part in plain.parts[:2]]
    scaled = [replace(part, left=part.left / span, latex=_over("e", part.latex)) for part in loop]
    next_state = [
        replace(
            part,
            left=part.left / root,
            at=(1, 0),
            plus_transpose=False,
            latex=_over(r"\sqrt{e}", part.latex),
        )
        for part in loop
    ]
    last = SumPart(
        unknown=S, left=-np.eye(n)[None], right=np.eye(n)[None], at=(1, 1), latex=("-", "")
    )
    return DoubleSum(
        rules=len(A),
        blocks=(n, n, q, m),
        parts=(
            *scaled,
            *next_state,
            last,
            *_spent(F / root, G / root, S, M, 2, (r"\tfrac{1}{\sqrt{e}}", r"\tfrac{1}{\sqrt{e}}")),
        ),
        fixed=_ones((q, m), 2),
        corners=corners,
    )


def _spent(
    F: Array, G: Array, S: Unknown, M: Unknown, row: int, factors: tuple[str, str]
) -> tuple[SumPart, SumPart]:
    """Return F S and G M_j below the loop, the first in this block row."""
    eye = np.eye(S.rows)[None]
    return (
        SumPart(unknown=S, left=F[None], right=eye, at=(row, 0), latex=(f"{factors[0]}F", "")),
        SumPart(
            unknown=M,
            left=G[None],
            right=eye,
            at=(row + 1, 0),
            member=gain_member(M),
            latex=(f"{factors[1]}G", ""),
            symbol=gain_symbol(M),
        ),
    )


def _ones(sizes: tuple[int, int], row: int) -> tuple[KnownBlock, ...]:
    """Return -I in the diagonal blocks from this block row on."""
    return tuple(
        KnownBlock(value=-np.eye(size)[None], at=(row + k, row + k), latex="-I")
        for k, size in enumerate(sizes)
    )


def _named(latex: tuple[str, str]) -> tuple[str, str]:
    return latex[0].replace("A_{i}", "N_{i}"), latex[1]


def _over(divisor: str, latex: tuple[str, str]) -> tuple[str, str]:
    sign = "-" if latex[0].startswith("-") else ""
    return rf"{sign}\tfrac{{1}}{{{divisor}}}{latex[0].removeprefix('-')}", latex[1]


def lqr_pdc_condition(
    model: Controlled,
    Q: ArrayLike,
    R: ArrayLike,
    *,
    relaxation: str = "wang-tanaka-griffin",
    deviations: ArrayLike = 1.0,
    sample_time: float | None = None,
    span: float = 1.0,
) -> Condition:
    """Pose the module's LMIs; the objective is trace W, the mean cost from random x(0).

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    Q, R : (n, n) positive semidefinite and (m, m) positive definite, symmetric.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    deviations : standard deviation of each state of x(0), (n,) or one number; or L, (n, n), where
        they are correlated with covariance L L'.
    sample_time : T in s of x+ = A x + B u; None takes the model's own, continuous where it has
        none.
    span : e in discrete time; changes the numbers, not what is feasible.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``S``, ``M``, ``W`` and
    those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, weights that are not symmetric or not
        definite, an unknown relaxation.

    Source: Tanaka and Wang (2001), chapter 6.
    """
    pose = relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    F = weight_factor(symmetric("Q", Q, n, definite=False))
    G = weight_factor(symmetric("R", R, m, definite=True))
    S = Unknown("S", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    W = Unknown("W", n, n, symmetric=True)
    corners = corners_of(model)
    if sample_time_of(model, sample_time) is None:
        loop = _cost_loop(A, B, F, G, S, M, corners)
    else:
        loop = _sampled_cost_loop(A, B, F, G, S, M, corners, span)
    slack, double_sum = pose(loop)
    return Condition(
        name=f"guaranteed quadratic cost, {relaxation}",
        unknowns=(S, M, W, *slack),
        lmis=(_cost_bound(W, S, initial_factor(deviations, n)), *double_sum),
        objective={"W": np.eye(n)[None]},
        source="Tanaka and Wang (2001), chapter 6",
    )


def largest_lmi(S: Unknown) -> LMI:
    """Pose S <= 1e6 I, in states where P is about 1: keeps S finite where a state costs nothing."""
    return bounded(S, LARGEST_S)


def initial_factor(deviations: ArrayLike, size: int) -> Array:
    """Return L, (size, size): the covariance of x(0) is L L'.

    Raises
    ------
    ModelError : a shape, or an entry, that makes no sense.
    """
    if np.ndim(deviations) < 2:
        return np.diag(positive_vector("deviations", deviations, size))
    factor = np.asarray(deviations, dtype=np.float64)
    if factor.shape != (size, size) or not np.isfinite(factor).all() or not factor.any():
        raise ModelError(
            f"deviations has shape {factor.shape}; ({size},) standard deviations are needed, or "
            f"({size}, {size}) L, finite and not zero, with the covariance L L'"
        )
    return factor


def _cost_bound(W: Unknown, S: Unknown, factor: Array) -> LMI:
    """Pose [[W, L'], [L, S]] > 0, which is S > 0 and W > L' S^-1 L."""
    eye = np.eye(S.rows)[None]
    return LMI(
        name="bound of the cost",
        blocks=(S.rows, S.rows),
        terms=(
            Term(unknown=W, left=eye, right=eye),
            Term(unknown=S, left=eye, right=eye, at=(1, 1)),
        ),
        constants=(Constant(value=factor.T[None], at=(0, 1), latex=r"L^\top"),),
    )


def weight_factor(weight: Array) -> Array:
    """Return F, (rank, size), with F' F = weight."""
    eigenvalues, vectors = np.linalg.eigh(weight)
    # Smaller eigenvalues of a singular weight are rounding, and may be negative.
    keep = eigenvalues > 1e-14 * np.abs(eigenvalues).max()
    return np.asarray((vectors[:, keep] * np.sqrt(eigenvalues[keep])).T)
