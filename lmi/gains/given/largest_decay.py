"""The decay rate that one relaxation shows for given gains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.diagnosis import binding_items
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.relaxation_search import Goal, goal_of
from takagi.lmi.gains.given.condition import GivenLoop, given_loop
from takagi.lmi.parameter_search.largest_parameter import extreme_parameter
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums.relaxations import Relaxation, relaxation_named

# The search begins at the rate at which P = I satisfies every Theta_ij, less this share.
BELOW = 0.1
# If V(x+) is below this share of V, the state is practically at rest after one step, and a larger
# rate has no meaning.
LEAST_CONTRACTION = 1e-8
# As ``max_decay_rate``: relative tolerance of the largest rate.
TOLERANCE = 1e-6


@limited
def closed_loop_decay(
    model: Controlled,
    gains: ArrayLike,
    *,
    decay_rate: Goal = "max",
    relaxation: str = "wang-tanaka-griffin",
    overlap: ArrayLike | None = None,
    active_rules: int | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return the largest alpha, and its P, that a relaxation shows for u = -sum_j h_j K_j x.

    V' <= -2 alpha V with V = x' P x along every blend, however the memberships move; in discrete
    time V(x+) <= e^(-2 alpha T) V(x).  The gains are given: nothing is designed.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    gains : K (r, m, n), or (m, n) for one gain in every rule; u = -K x.
    decay_rate : "max", or alpha in 1/s, which is then decided.
    relaxation : by name, as for ``pdc``, except "auto": ``closed_loop_ladder`` tries all of them.
        "common-gain" with gains that differ poses all pairs.
    overlap, active_rules : known bounds of the memberships, as for ``pdc``.
    scales : (n,) engineering range of each state; None balances the loops.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.
    time_limit : seconds for all solver calls together.

    Returns
    -------
    An ``Answer``.  ``decay_rate`` is the rate that the unknowns show; if it is negative, V may
    grow, but no faster than at this rate.  ``bound`` is above every rate that this relaxation can
    show, to solver accuracy, or inf.
    Nothing is proved here: ``takagi.certificates.certify`` proves a loop.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation or one that does not apply, inputs that are
        dependent or do nothing.

    Source: Tanaka, Ikeda and Wang (1998), theorems 1 and 2; Tanaka and Wang (2001), section 3.2.
    """
    relaxation_named(relaxation)
    goal = goal_of(decay_rate)
    loop = given_loop(
        model, gains, overlap=overlap, active_rules=active_rules, sample_time=sample_time
    ).scaled(scales)
    return largest_decay(loop, relaxation) if goal == "max" else decided(loop, goal, relaxation)


def decided(loop: GivenLoop, decay_rate: float, relaxation: str | Relaxation) -> Answer:
    """Return whether a relaxation shows one decay rate, in 1/s."""
    condition = loop.condition(decay_rate, relaxation)
    outcome = decide(condition)
    rate = decay_rate if outcome.status == "candidate" else None
    return replace(_answer(loop, condition, outcome), decay_rate=rate)


def largest_decay(loop: GivenLoop, relaxation: str | Relaxation) -> Answer:
    """Return the largest decay rate that a relaxation shows, with its P."""
    discrete = loop.sample_time is not None
    found = extreme_parameter(
        _begun(loop, relaxation),
        "contraction" if discrete else "alpha",
        largest=not discrete,
        tolerance=TOLERANCE,
        limit=LEAST_CONTRACTION if discrete else None,
    )
    answer = _answer(loop, found.condition, found.outcome)
    if not answer.found:
        return answer
    return replace(answer, decay_rate=_rate(loop, found.value), bound=_rate(loop, found.bound))


def _begun(loop: GivenLoop, relaxation: str | Relaxation) -> Condition:
    """Return the condition at rate 0 if it holds; else at a lower rate, which P = I shows."""
    at_rest = loop.condition(0.0, relaxation)
    if decide(at_rest).status == "candidate":
        return at_rest
    n = loop.G.shape[2]
    every = loop.G.reshape(-1, n, n)
    if loop.sample_time is None:
        grows = float(np.linalg.eigvalsh(every + every.transpose(0, 2, 1)).max()) / 2
        size = float(np.abs(every).max())
    else:
        grows = float(np.log(np.linalg.norm(every, 2, axis=(1, 2)).max())) / loop.sample_time
        size = 1.0 / loop.sample_time
    return loop.condition(-(max(grows, 0.0) + BELOW * size), relaxation)


def _rate(loop: GivenLoop, value: float) -> float:
    """Return the decay rate in 1/s for a value of the parameter."""
    if loop.sample_time is None:
        return value
    return float(-np.log(value) / (2 * loop.sample_time)) if value > 0 else np.inf


def _answer(loop: GivenLoop, condition: Condition, outcome: Outcome) -> Answer:
    answer = outcome.as_answer(condition, loop.s)
    if outcome.status == "candidate":
        P = outcome.values["P"][0]
        P = P / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
        return replace(answer, P=P / loop.s / loop.s[:, None])
    if outcome.status == "unknown":
        return replace(answer, diagnosis=outcome.unsettled("ask for a lower decay rate"))
    names = [lmi.name for lmi in condition.lmis if lmi.name not in ("scale of P",)]
    return replace(
        answer,
        diagnosis=(
            f"{condition.name}: {binding_items(condition, outcome.multipliers, *names)}; take a "
            'richer relaxation ("liu-zhang", "polya-2"), or ask for a lower decay rate'
        ),
    )
