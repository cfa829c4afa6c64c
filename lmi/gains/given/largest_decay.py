"""The decay rate that one relaxation shows for given gains."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Design, RelaxationResult
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, binding_items
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.pdc import Ladder, checked_names
from takagi.lmi.gains.decay.relaxation_search import Goal, goal_of
from takagi.lmi.gains.given.condition import GivenLoop, given_loop
from takagi.lmi.parameter_search.largest_parameter import extreme_parameter
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums.corner_rules import product_rules
from takagi.lmi.sums.membership_points import at_points, number_of_points
from takagi.lmi.sums.relaxation_sizes import (
    MOST_WORK,
    NAMES,
    PRODUCTS,
    RelaxationSize,
    size_of,
    work_of,
)
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


ANY = "any relaxation"
# Every relaxation implies the condition at single blends, which is posed at about so many blends.
FEW_BLENDS = 60
# Rates with a relative difference below this count as equal.
SAME = 1e-3


def closed_loop_ladder(
    model: Controlled,
    gains: ArrayLike,
    *,
    decay_rate: Goal = "max",
    relaxations: Sequence[str] | None = None,
    overlap: ArrayLike | None = None,
    active_rules: int | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Ladder:
    """Return, for each relaxation, the decay rate that it shows for the same gains.

    Parameters
    ----------
    decay_rate : "max", or alpha in 1/s: then a row says whether the relaxation shows it.
    relaxations : by name, in the order in which they are tried; None takes all that apply, by the
        work of one iteration of the solver.
    model, gains and the others : as for ``closed_loop_decay``.

    Returns
    -------
    A ``Ladder``: a row for each relaxation, and a last one, "any relaxation", for the condition at
    single blends.  Every relaxation implies that one, so no relaxation shows more; the
    difference is the most that a relaxation may lose.  ``best`` has the given gains with the P that
    shows most.

    Raises
    ------
    ModelError : as ``closed_loop_decay``; no relaxations, or one twice.

    Source: as ``closed_loop_decay``.
    """
    names = None if relaxations is None else checked_names(relaxations)
    goal = goal_of(decay_rate)
    loop = given_loop(
        model, gains, overlap=overlap, active_rules=active_rules, sample_time=sample_time
    ).scaled(scales)
    results: list[RelaxationResult] = []
    best: Design | None = None
    for name in _applicable(loop) if names is None else names:
        result, answer = _tried(loop, goal, name)
        if answer is not None and answer.P is not None and answer.decay_rate is not None:
            note = _gained(best, answer.decay_rate, goal)
            result = replace(result, note=note)
            if best is None or answer.decay_rate > best.decay_rate:
                best = Design(
                    gains=loop.gains,
                    P=answer.P,
                    decay_rate=answer.decay_rate,
                    margin=answer.margin,
                    relaxation=name,
                    answer=answer,
                )
        results.append(result)
    results.append(_outside(loop, goal))
    return Ladder(tuple(results), best)


def _applicable(loop: GivenLoop) -> tuple[str, ...]:
    """Return the relaxations that apply, by the work of one iteration."""
    if not loop.scheduled or len(loop.G) == 1:
        # Theta_ij does not change with j: the rules alone decide, and every relaxation is the same.
        return ("common-gain",)
    names = tuple(name for name in NAMES if name != "common-gain")
    if loop.corners is not None and len(product_rules(loop.corners).sizes) > 1:
        names += PRODUCTS
    return tuple(sorted(names, key=lambda name: work_of(_size(loop, name))))


def _tried(loop: GivenLoop, goal: Goal, name: str) -> tuple[RelaxationResult, Answer | None]:
    size = _size(loop, name)
    result = RelaxationResult(
        relaxation=name,
        status="not tried",
        lmis=size.lmis,
        variables=triangle(loop.G.shape[2]) + size.slack_variables,
        width=size.width,
        note=f"too large: {size.lmis} LMIs, the widest {size.width}",
    )
    if work_of(size) > MOST_WORK:
        return result, None
    started = time.perf_counter()
    answer = largest_decay(loop, name) if goal == "max" else decided(loop, goal, name)
    found = replace(
        result,
        status=answer.status,
        seconds=time.perf_counter() - started,
        margin=answer.margin,
        decay_rate=answer.decay_rate,
        note="not shown" if answer.status == "infeasible" else "not settled",
    )
    return found, answer


def _gained(best: Design | None, rate: float, goal: Goal) -> str:
    if best is None or goal != "max":
        return "shown"
    more = rate - best.decay_rate
    if more <= SAME * abs(best.decay_rate):
        return f"no more than {best.relaxation}"
    return f"{more:+.3g} 1/s over {best.relaxation}"


def _outside(loop: GivenLoop, goal: Goal) -> RelaxationResult:
    """Return the bound of all relaxations: the condition at single blends."""
    r = len(loop.G)
    fine = [p for p in (12, 8, 6, 4, 3) if number_of_points(r, loop.corners, p) <= FEW_BLENDS]
    pose = at_points(fine[0] if fine else 2)
    started = time.perf_counter()
    answer = largest_decay(loop, pose) if goal == "max" else decided(loop, goal, pose)
    assert answer.condition is not None  # it has been posed
    blends = [lmi for lmi in answer.condition.lmis if lmi.name.endswith("blend")]
    count = sum(lmi.count for lmi in blends)
    bounded = answer.found and np.isfinite(answer.bound)
    ruled_out = goal != "max" and answer.status == "infeasible"
    return RelaxationResult(
        relaxation=ANY,
        status="infeasible" if ruled_out else "bound",
        lmis=count,
        variables=triangle(loop.G.shape[2]),
        width=max(lmi.size for lmi in blends),
        seconds=time.perf_counter() - started,
        margin=answer.margin,
        decay_rate=answer.bound if goal == "max" and bounded else None,
        note=f"{'ruled out' if ruled_out else 'none shows more,'} at {count} blends",
    )


def _size(loop: GivenLoop, name: str) -> RelaxationSize:
    n = loop.G.shape[2]
    return size_of(name, loop.double_sum(Unknown("P", n, n, symmetric=True), 0.0))
