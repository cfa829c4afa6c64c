"""All relaxations for the same gains: the decay rate that each shows, and its cost."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Design
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.relaxation_search import Goal, goal_of
from takagi.lmi.gains.decay.relaxation_table import Ladder, checked_names
from takagi.lmi.gains.given.condition import GivenLoop, given_loop
from takagi.lmi.gains.given.largest_decay import decided, largest_decay
from takagi.lmi.relaxation_result import RelaxationResult
from takagi.lmi.sums.corner_rules import product_rules
from takagi.lmi.sums.membership_points import at_points, number_of_points
from takagi.lmi.sums.relaxation_order import MOST_WORK, NAMES, PRODUCTS, work_of
from takagi.lmi.sums.relaxation_sizes import RelaxationSize, size_of

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
