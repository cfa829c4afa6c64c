r"""One quadratic function for a model with norm-bounded uncertainty.

For x' = A(h) x + sum_k D_k(h) p_k with |p_k| <= |E_k(h) x|: if for every vertex i

    [ He(P A_i) + 2 alpha P   P D_ki       tau_k E_ki' ]
    [ D_ki' P                 -tau_k I     0           ]  < 0   (p_k and q_k for each k)
    [ tau_k E_ki              0            -tau_k I    ]

then, as everything is affine in (A_i, D_ki, E_ki), the same holds for every blend; taking p_k along
and |p_k|^2 <= |E_k x|^2 into account, V' + 2 alpha V <= sum_k tau_k (|p_k|^2 - |E_k x|^2) <= 0.
Where D_k or E_k is the same at all vertices, D_k Delta_k E_k of a blend is the blend of those of
the vertices, so that each vertex may be treated by itself, with a tau_ki of its own.
In discrete time the first block row and column become

    [ -rho^2 P   A_i' P ]
    [ P A_i      -P     ],  with P D_ki in the second row,  rho = e^(-alpha T).

For one block, one vertex and alpha = 0 it is necessary too: P exists if and only if A is stable and
the H-infinity norm of E (s I - A)^-1 D is below 1.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1; Khargonekar, Petersen
and Zhou (1990), IEEE Trans. Automatic Control 35(3), for the equivalence.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.actuator_rates import gain_stack, of_pairs, pair_means, pairs_of
from takagi.lmi.analysis.decay_rate import answer_in_states, change_of, vertex_weight
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    decay_parameter,
    input_stack,
    number,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.region import Uncertainty, UncertaintyBlock, blocks_of
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power, state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, binding_items
from takagi.lmi.expressions.expression import matrix, symmetric_block
from takagi.lmi.solver.time_limit import limited


def robust_lyapunov_condition(
    model: Vertices,
    uncertainty: Uncertainty,
    *,
    gains: ArrayLike | None = None,
    decay_rate: float | Fraction = 0.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the module's LMI at every vertex, with 0 < P <= I and tau_k <= 100, which fix the scale.

    Parameters
    ----------
    model : a model (its A, and B with gains), or A itself, (N, n, n) or (n, n).
    uncertainty : one ``NormBounded`` or several; F counts only with gains.
    gains : K, (r, m, n), of u = -sum_j h_j K_j x; the vertices are then those of the closed loop,
        one for each pair of rules.  None takes the model as it is, with u = 0.
    decay_rate : alpha in 1/s.
    sample_time : T in s for raw arrays of discrete time; None takes the model's own.

    Raises
    ------
    ModelError : shapes, entries that are not finite, a block that does nothing.
    """
    A, channels = _loop(model, uncertainty, gains)
    step = sample_time_of(model, sample_time)
    return _condition(A, channels, number("decay_rate", decay_rate), step)


@limited
def robust_lyapunov(
    model: Vertices,
    uncertainty: Uncertainty,
    *,
    gains: ArrayLike | None = None,
    decay_rate: float = 0.0,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return a candidate P with V' <= -2 alpha V for every blend and every |Delta_k| <= 1.

    In discrete time V(x+) <= e^(-2 alpha T) V(x).  h and Delta_k may move arbitrarily fast.

    Parameters
    ----------
    scales : (n,) engineering range of each state; None balances the vertices.
    others : as for ``robust_lyapunov_condition``.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    An ``Answer``; ``values`` holds a multiplier ``tau1``, ``tau2``, ... for each block, and
    ``decay_rate`` is the one that was asked for.  Nothing is proved.  A no is about one P with
    these multipliers: without gains, for one block that enters, or is driven, alike at all
    vertices there is then no such P at all; otherwise there may be (the vertex of two rules'
    gains is a mean that no blend is equal to).

    Raises
    ------
    ModelError : as ``robust_lyapunov_condition``, and scales that are not positive.
    """
    A, channels = _loop(model, uncertainty, gains)
    alpha = float(number("decay_rate", decay_rate))
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales)
    inputs = np.ones(channels[0].F.shape[2])
    scaled = tuple(channel.scaled(s, inputs) for channel in channels)
    condition = _condition(A * s / s[:, None], scaled, alpha, step)
    answer = answer_in_states(condition, decide(condition), A, s, step=step, diagnose=_diagnosis)
    # The rate of the vertices themselves may be larger.
    rate = alpha if answer.found else None
    return of_pairs(replace(answer, decay_rate=rate), gains)


def _loop(
    model: Vertices, uncertainty: Uncertainty, gains: ArrayLike | None
) -> tuple[Array, tuple[UncertaintyBlock, ...]]:
    """Return the vertices A and the blocks, with the loop closed where there are gains."""
    A = vertex_stack(model).astype(np.float64)
    r, n = A.shape[:2]
    if gains is None:
        source = getattr(model, "B", None)
        m = 0 if source is None else int(np.shape(source)[-1])
        return A, blocks_of(uncertainty, r, n, m)
    B = input_stack(model, A).astype(np.float64)
    m = B.shape[2]
    K = gain_stack(gains, r, m, n)
    closed = tuple(
        UncertaintyBlock(
            pair_means(channel.D),
            pairs_of(channel.E, channel.F, K),
            np.zeros((r * (r + 1) // 2, channel.E.shape[1], m)),
        )
        for channel in blocks_of(uncertainty, r, n, m)
    )
    return pairs_of(A, B, K), closed


def _condition(
    A: Array, channels: tuple[UncertaintyBlock, ...], alpha: float | Fraction, step: float | None
) -> Condition:
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    A_i, rate = matrix(A, "A_{i}"), decay_parameter(alpha, step)
    weight = vertex_weight(A) if step is None else 1.0
    # The channels' rows are measured so that their multipliers weigh as much as the rest.
    unit = float(nearest_power(np.array(np.sqrt(weight))))
    cells = {(0, 0): change_of(P, A_i, rate, None)}
    if step is not None:
        cells = {(0, 0): -rate * P, (1, 0): P @ A_i, (1, 1): -P}
    enters, sizes = 0 if step is None else 1, [n] if step is None else [n, n]
    taus, scales = [], []
    for k, channel in enumerate(channels, start=1):
        # One multiplier a vertex where the block may be read by vertex.
        count = len(channel.D) if channel.enters_alike or channel.driven_alike else 1
        tau = Unknown(f"tau{k}", 1, 1, count=count, latex=rf"\tau_{{{k}}}")
        tau_i = tau.members(np.arange(count), rf"\tau_{{{k}{'i' if count > 1 else ''}}}")
        D, E = matrix(channel.D, f"D_{{{k}i}}"), matrix(channel.E, f"E_{{{k}i}}")
        driven, seen = len(sizes), len(sizes) + 1
        sizes += [D.shape[1], E.shape[0]]
        cells[enters, driven], cells[0, seen] = unit * (P @ D), unit * (tau_i * E.T)
        cells[driven, driven] = -(unit**2) * tau_i * np.eye(D.shape[1])
        cells[seen, seen] = -(unit**2) * tau_i * np.eye(E.shape[0])
        taus.append(tau)
        # No loss, as P and the multipliers may be divided by any number.
        scales.append((tau_i <= 100 * np.eye(1)).named(f"scale of {tau.name}"))
    return pose(
        positive_definite(P),
        scale_bound(P),
        *scales,
        (symmetric_block(tuple(sizes), cells) << 0).named(
            "uncertain vertex",
            rf"i = 1, \dots, {len(A)}",
            weight=weight,
            labels=tuple(f"vertex {i + 1} of {len(A)}" for i in range(len(A))),
        ),
        unknowns=(P, *taus),
        name="common quadratic Lyapunov function, norm-bounded uncertainty",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1",
    )


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled("lower the decay rate or the uncertainty a little, or give scales")
    binding = binding_items(condition, outcome.multipliers, "uncertain vertex")
    return (
        f"no common P for all that is uncertain: {binding}; shrink the uncertainty, lower the "
        "decay rate, or shrink the box that these vertices span"
    )
