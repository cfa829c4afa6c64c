"""The LMIs of parallel distributed compensation; nothing here solves them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np

from takagi.lmi.analysis.quadratic_condition import vertex_weight
from takagi.lmi.argument_checks import (
    corners_of,
    input_stack,
    number,
    rate_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import LMI, Array, Condition, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion
from takagi.lmi.gains.requirements.closed_loop import closed_loop, gain_unknown
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.gains.requirements.requirements import Requirements, required_sums
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import Relaxation, relaxation_named


class Controlled(Protocol):
    """What pdc reads of a model: A (r, n, n) and B (r, n, m)."""

    @property
    def A(self) -> Array: ...

    @property
    def B(self) -> Array: ...


# Size of Q, in scaled states, where limits fix the ellipsoid and it is not a matter of scale.
LARGEST_ELLIPSOID = 1e3


def pdc_condition(
    model: Controlled,
    *,
    decay_rate: float = 0.0,
    relaxation: str | Relaxation = "wang-tanaka-griffin",
    limits: Limits | None = None,
    requirements: Requirements | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0, Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q, Q > 0.

    Then u = -sum_j h_j K_j x with K_j = M_j Q^-1 gives V' <= -2 alpha V for V = x' Q^-1 x.  The
    objective is the input effort nu, K_j Q K_j' <= nu I: the largest input on x' P x <= 1.
    Discrete time: Theta_ij as in ``closed_loop``.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    decay_rate : alpha in 1/s.
    relaxation : how the double sum is made LMIs; see ``relaxations``.  Or what poses it.
    limits : on inputs, states and gains, in the model's coordinates.
    requirements : eigenvalues, uncertain plants, known memberships; in those coordinates.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns
    -------
    The condition, in the model's coordinates as they are.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, an unknown relaxation.

    Source: Tanaka and Wang (2001), section 3.3.
    """
    name = relaxation if isinstance(relaxation, str) else ""
    pose = relaxation if callable(relaxation) else relaxation_named(relaxation)
    alpha = number("decay_rate", decay_rate)
    step = sample_time_of(model, sample_time)
    posed = double_sums(model, alpha, name, requirements, step)
    Q, M = posed.Q, posed.M
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    relaxed = [pose(loop) for loop in posed.sums]
    slack = tuple(unknown for unknowns, _ in relaxed for unknown in unknowns)
    sums = tuple(lmi for _, lmis in relaxed for lmi in lmis)
    limit_unknowns, restrictions = limit_lmis(Q, M, limits)
    # Without limits Q is determined up to a factor, and Q <= I fixes it; with limits its size
    # matters.
    largest = LARGEST_ELLIPSOID if limits is not None and limits.level else 1.0
    return Condition(
        name=", ".join(words for words in ("parallel distributed compensation", name) if words),
        unknowns=(Q, M, nu, *posed.unknowns, *slack, *limit_unknowns),
        lmis=(
            positive(Q),
            bounded(Q, largest),
            *sums,
            *posed.lmis,
            effort_lmi(Q, M, nu),
            *restrictions,
        ),
        objective={"nu": np.ones((1, 1, 1))},
        parameters=rate_parameter(alpha, step),
        source="Tanaka and Wang (2001), section 3.3",
    )


@dataclass(frozen=True, slots=True, eq=False)
class DoubleSums:
    """All double sums of a design, the first that of the decay rate, before they are relaxed.

    Attributes
    ----------
    Q, M : the unknowns that they share.
    unknowns, lmis : that they need in addition.
    """

    Q: Unknown
    M: Unknown
    sums: tuple[DoubleSum, ...]
    unknowns: tuple[Unknown, ...]
    lmis: tuple[LMI, ...]


def double_sums(
    model: Controlled,
    alpha: float | Fraction,
    relaxation: str,
    requirements: Requirements | None,
    step: float | None,
) -> DoubleSums:
    """Return the double sums of ``pdc_condition``.

    Parameters
    ----------
    relaxation : for "common-gain" M has one member, for all others one a rule.
    step : T in s; None for continuous time.
    """
    A = vertex_stack(model)
    B = input_stack(model, A)
    r, n, m = B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    loop = closed_loop(
        A,
        B,
        Q,
        M,
        weight=theta_weight(A, float(alpha), step),
        discrete=step is not None,
        corners=corners_of(model),
    )
    if requirements is None:
        return DoubleSums(Q, M, (loop,), (), ())
    sums = required_sums(loop, A, B, Q, M, requirements, discrete=step is not None)
    return DoubleSums(Q, M, *sums)


def size_of_motion(A: Array, alpha: float, step: float | None) -> float:
    """Return max_i 2 |A_i|, of A_i - I in discrete time, or what the decay rate asks if more."""
    asked_rate = alpha if step is None else -np.expm1(-alpha * step)
    return max(vertex_weight(motion(A, step)), 2.0 * asked_rate)


def theta_weight(A: Array, alpha: float, step: float | None) -> float:
    """Return the natural size of Theta_ij for Q <= I.

    In discrete time at most 1: Theta's own blocks -rho^2 Q and -Q leave no more.  It is small
    where the sample time is, since V then changes little in a step.
    """
    size = size_of_motion(A, alpha, step)
    return size if step is None else min(1.0, size)


def effort_lmi(Q: Unknown, M: Unknown, nu: Unknown) -> LMI:
    """Pose [[Q, M_i'], [M_i, nu I]] >= 0, which is K_i Q K_i' <= nu I."""
    n, m, r = Q.rows, M.rows, M.count
    eye = np.eye(n)[None]
    return LMI(
        name="input effort",
        blocks=(n, m),
        terms=(
            Term(unknown=Q, left=eye, right=eye),
            Term(
                unknown=M,
                left=np.eye(m)[None],
                right=eye,
                at=(1, 0),
                members=np.arange(r),
                symbol=M.symbol if r == 1 else f"{M.symbol}_i",
            ),
            Term(unknown=nu, left=np.eye(m)[None], at=(1, 1), latex=("", "I")),
        ),
        count=r,
        # At the least effort this inequality holds with equality, so it cannot keep a margin.
        strict=False,
        index=rf"i = 1, \dots, {r}",
    )
