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

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.actuator_rates import gain_stack, of_pairs, pair_means, pairs_of
from takagi.lmi.analysis.decay_rate import answer_in_states, vertex_weight
from takagi.lmi.analysis.pole_region import coefficient_latex
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    input_stack,
    number,
    rate_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.region import Uncertainty, UncertaintyBlock, blocks_of
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power, state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, binding_items
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
    taus = tuple(_tau(channel, k) for k, channel in enumerate(channels, start=1))
    nominal: Callable[[Array, Unknown], tuple[Term, ...]] = _flow if step is None else _step
    weight = vertex_weight(A) if step is None else 1.0
    first = (n,) if step is None else (n, n)
    sizes = [size for c in channels for size in (c.D.shape[2], c.E.shape[1])]
    # The channels' rows are measured so that their multipliers weigh as much as the rest.
    unit = float(nearest_power(np.array(np.sqrt(weight))))
    terms = list(nominal(A, P))
    for k, (channel, tau) in enumerate(zip(channels, taus, strict=True)):
        terms += _channel_terms(channel, P, tau, len(first) - 1, len(first) + 2 * k, unit)
    decay = LMI(
        name="uncertain vertex",
        blocks=(*first, *sizes),
        terms=tuple(terms),
        sign=-1,
        count=len(A),
        weight=weight,
        labels=tuple(f"vertex {i + 1} of {len(A)}" for i in range(len(A))),
        index=rf"i = 1, \dots, {len(A)}",
    )
    return Condition(
        name="common quadratic Lyapunov function, norm-bounded uncertainty",
        unknowns=(P, *taus),
        lmis=(positive(P), bounded(P), *(_bounded(tau) for tau in taus), decay),
        parameters=rate_parameter(alpha, step),
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1",
    )


def _tau(channel: UncertaintyBlock, k: int) -> Unknown:
    """Return the multiplier of a block: one a vertex where the block may be read by vertex."""
    by_vertex = channel.enters_alike or channel.driven_alike
    count = len(channel.D) if by_vertex else 1
    return Unknown(f"tau{k}", 1, 1, count=count, latex=rf"\tau_{{{k}}}")


def _bounded(tau: Unknown) -> LMI:
    """Pose tau <= 100: no loss, as P and tau may be divided by any number."""
    return LMI(
        name=f"scale of {tau.name}",
        blocks=(1,),
        terms=(Term(unknown=tau, left=np.ones((1, 1, 1)), members=np.arange(tau.count)),),
        constants=(Constant(value=np.full((1, 1, 1), -100.0), latex="-100"),),
        sign=-1,
        count=tau.count,
        strict=False,
    )


def _flow(A: Array, P: Unknown) -> tuple[Term, ...]:
    eye = np.eye(A.shape[1])[None]
    return (
        Term(unknown=P, left=eye, right=A, plus_transpose=True, latex=("", "A_{i}")),
        Term(unknown=P, left=2 * eye, right=eye, parameter="alpha", latex=(r"2\alpha", "")),
    )


def _step(A: Array, P: Unknown) -> tuple[Term, ...]:
    eye = np.eye(A.shape[1])[None]
    return (
        Term(unknown=P, left=-eye, right=eye, parameter="contraction", latex=(r"-\rho^2", "")),
        Term(unknown=P, left=eye, right=A, at=(1, 0), latex=("", "A_{i}")),
        Term(unknown=P, left=-eye, right=eye, at=(1, 1), latex=("-", "")),
    )


def _channel_terms(
    channel: UncertaintyBlock, P: Unknown, tau: Unknown, enters: int, block: int, unit: float
) -> tuple[Term, ...]:
    """Return the block's terms: P D in block row ``enters``, tau E' in the first."""
    n = P.rows
    p, q = channel.D.shape[2], channel.E.shape[1]
    square = -(unit**2)
    k, minus = tau.name.removeprefix("tau"), coefficient_latex(square)
    by_vertex = tau.count > 1
    members = np.arange(tau.count) if by_vertex else None
    symbol = rf"\tau_{{{k}i}}" if by_vertex else tau.symbol
    return (
        Term(
            unknown=P,
            left=np.eye(n)[None],
            right=unit * channel.D,
            at=(enters, block),
            latex=(coefficient_latex(unit), f"D_{{{k}i}}"),
        ),
        Term(
            unknown=tau,
            left=unit * channel.E.transpose(0, 2, 1),
            at=(0, block + 1),
            members=members,
            latex=(coefficient_latex(unit), rf"E_{{{k}i}}^\top"),
            symbol=symbol,
        ),
        *(
            Term(
                unknown=tau,
                left=square * np.eye(size)[None],
                at=(block + where, block + where),
                members=members,
                latex=(minus, "I"),
                symbol=symbol,
            )
            for where, size in enumerate((p, q))
        ),
    )


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled("lower the decay rate or the uncertainty a little, or give scales")
    binding = binding_items(condition, outcome.multipliers, "uncertain vertex")
    return (
        f"no common P for all that is uncertain: {binding}; shrink the uncertainty, lower the "
        "decay rate, or shrink the box that these vertices span"
    )
