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
from takagi.lmi.condition.statements import lmi_of, pose, scale_bound
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion
from takagi.lmi.expressions.expression import Expression, He, block, identity, matrix, trace
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.double_sum import double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.errors import ModelError

# Largest S in states where P is about 1: keeps S finite where a state costs nothing, at a cost of
# this much of the cost.
LARGEST_S = 1e6


def _cost_loop(A: Array, B: Array, F: Array, G: Array, S: Unknown, M: Unknown) -> Expression:
    """Return the module's Theta_ij: the closed loop, with the cost's factors below it."""
    M_j = M.over("j")
    loop = matrix(A, "A_{i}", over="i") @ S - matrix(B, "B_{i}", over="i") @ M_j
    states, inputs = -identity(len(F)), -identity(M.rows)
    return block(
        [
            [He(loop), None, None],
            [matrix(F, "F") @ S, states, 0],
            [matrix(G, "G") @ M_j, 0, inputs],
        ]
    )


def _sampled_cost_loop(
    A: Array, B: Array, F: Array, G: Array, S: Unknown, M: Unknown, span: float
) -> Expression:
    """Return the module's Theta_ij in discrete time; ``span`` is e."""
    M_j, root = M.over("j"), float(np.sqrt(span))

    def loop(over: float, name: str) -> Expression:
        N_i = matrix(motion(A, 1.0) / over, rf"\tfrac{{1}}{{{name}}}N_{{i}}", over="i")
        return N_i @ S - matrix(B / over, rf"\tfrac{{1}}{{{name}}}B_{{i}}", over="i") @ M_j

    states, inputs = -identity(len(F)), -identity(M.rows)
    spent = [
        matrix(factor / root, rf"\tfrac{{1}}{{\sqrt{{e}}}}{name}")
        for factor, name in ((F, "F"), (G, "G"))
    ]
    return block(
        [
            [He(loop(span, "e")), None, None, None],
            [loop(root, r"\sqrt{e}"), -S, 0, 0],
            [spent[0] @ S, 0, states, 0],
            [spent[1] @ M_j, 0, 0, inputs],
        ]
    )


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

    Returns the condition in the model's coordinates as they are, with the unknowns ``S``, ``M``,
    ``W`` and those of the relaxation.  Nothing is solved.

    Raises ModelError: shapes, entries that are not finite, weights that are not symmetric or not
    definite, an unknown relaxation.
    """
    relaxed = relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    F = weight_factor(symmetric("Q", Q, n, definite=False))
    G = weight_factor(symmetric("R", R, m, definite=True))
    S = Unknown("S", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    W = Unknown("W", n, n, symmetric=True)
    if sample_time_of(model, sample_time) is None:
        theta = _cost_loop(A, B, F, G, S, M)
    else:
        theta = _sampled_cost_loop(A, B, F, G, S, M, span)
    # Without a decay rate: the cost says how fast.
    slack, double_sum = relaxed(double_sum_of(theta << 0, rules=r, corners=corners_of(model)))
    bound = block([[W, matrix(initial_factor(deviations, n).T, r"L^\top")], [None, S]])
    return pose(
        # S > 0 and W > L' S^-1 L
        (bound >> 0).named("bound of the cost"),
        *double_sum,
        minimise=trace(W),
        unknowns=(S, M, W, *slack),
        name=f"guaranteed quadratic cost, {relaxation}",
        source="Tanaka and Wang (2001), chapter 6",
    )


def largest_lmi(S: Unknown) -> LMI:
    """Pose S <= 1e6 I, in states where P is about 1: keeps S finite where a state costs nothing."""
    return lmi_of(scale_bound(S, LARGEST_S))


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


def weight_factor(weight: Array) -> Array:
    """Return F, (rank, size), with F' F = weight."""
    eigenvalues, vectors = np.linalg.eigh(weight)
    # Smaller eigenvalues of a singular weight are rounding, and may be negative.
    keep = eigenvalues > 1e-14 * np.abs(eigenvalues).max()
    return np.asarray((vectors[:, keep] * np.sqrt(eigenvalues[keep])).T)
