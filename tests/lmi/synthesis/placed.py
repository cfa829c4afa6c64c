"""Gains from a condition put together by hand: what several tests of double sums share."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import (
    LMI,
    Condition,
    DoubleSum,
    Outcome,
    Unknown,
    decide,
    pdc_condition,
    relaxation_named,
)
from takagi.lmi.gains.requirements.limits import Limits
from takagi.models import TSModel

Floats = NDArray[np.float64]
# Double sums, unknowns and LMIs to be added, from Q and M.
Added = tuple[Sequence[DoubleSum], tuple[Unknown, ...], tuple[LMI, ...]]
More = Callable[[Unknown, Unknown], Added]


def pendulum(sample_time: float | None = None) -> TSModel:
    """Two rules of a pendulum with torque; Euler's step in discrete time."""
    A = np.array([[[0.0, 1.0], [17.3, 0.0]], [[0.0, 1.0], [9.4, 0.0]]])
    B = np.array([[[0.0], [-2.0]], [[0.0], [-1.0]]])
    if sample_time is not None:
        A, B = np.eye(2) + sample_time * A, sample_time * B
    return TSModel(A, B, sample_time=sample_time)


def nothing(Q: Unknown, M: Unknown) -> Added:
    """Add nothing."""
    return (), (), ()


def placed(
    model: TSModel,
    more: More,
    *,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = -20.0,
    limits: Limits | None = None,
    effort: float = 1e4,
) -> tuple[Floats | None, Floats | None, Outcome, Condition]:
    """Return gains (r, m, n), P, the outcome and the condition; None, None where there are none."""
    condition = pdc_condition(model, relaxation=relaxation, decay_rate=decay_rate, limits=limits)
    Q, M = condition.unknowns[:2]
    loops, unknowns, lmis = more(Q, M)
    condition = condition.with_lmis(*lmis, unknowns=unknowns)
    for loop in loops:
        slack, posed = relaxation_named(relaxation)(loop)
        condition = condition.with_lmis(*posed, unknowns=slack)
    outcome = decide(condition, rows={"nu": effort})
    if outcome.status != "candidate":
        return None, None, outcome, condition
    P = np.linalg.inv(outcome.values["Q"][0])
    K = outcome.values["M"] @ P
    r, m, n = len(model.A), model.B.shape[2], model.A.shape[1]
    return np.broadcast_to(K, (r, m, n)), (P + P.T) / 2, outcome, condition


def blends(model: TSModel, K: Floats, count: int, seed: int = 0) -> tuple[Floats, Floats, Floats]:
    """Return A(h), B(h), K(h) at random and corner memberships."""
    r = len(model.A)
    h = np.concatenate([np.random.default_rng(seed).dirichlet(0.6 * np.ones(r), count), np.eye(r)])
    A, B, gain = (np.tensordot(h, part, 1) for part in (model.A, model.B, K))
    return A, B, gain
