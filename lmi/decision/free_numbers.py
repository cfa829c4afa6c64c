"""Decide a condition with equalities: solve them exactly, then the LMIs in what they leave free."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from takagi.lmi.answer import Status
from takagi.lmi.condition.evaluate import holds, margin
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.cone_program import Assembled
from takagi.lmi.decision.outcome import Outcome, objective_at
from takagi.lmi.equalities import ExactSolution, Parametrised, parametrised
from takagi.models.errors import ModelError

CONTRADICTION = (
    "the equalities contradict one another in exact arithmetic, for the numbers as they are "
    "stored; a float is the dyadic number it stores, so give decimals as strings or Fractions "
    "where the two sides are to agree"
)


def in_free_numbers(condition: Condition, solve: Callable[[Condition], Outcome]) -> Outcome:
    """Return the outcome of a condition with equalities, from a solver of LMIs.

    The values are those of the condition's own unknowns, and the margin is recomputed from them,
    equalities included.  Where the equalities have no solution the status is "infeasible", which
    elimination over the rationals has proved.
    """
    free = parametrised(condition)
    if free is None:
        return Outcome("infeasible", {}, -np.inf, -np.inf, {}, (), reason=CONTRADICTION)
    if not free.condition.unknowns:
        return _only_one(free)
    return lifted_outcome(free, solve(free.condition))


def _only_one(free: Parametrised) -> Outcome:
    """Return the outcome where the equalities leave nothing free: the one solution, tested."""
    condition, values = free.original, free.lifted({})
    checked_margin = margin(condition, values)
    solution = ExactSolution(condition=condition, values=free.exact(values))
    status: Status = "candidate" if holds(condition, checked_margin) else "unknown"
    if status == "unknown" and not solution.holds:
        status = "infeasible"
    objective = objective_at(condition, values)
    reason = (
        "" if status == "candidate" else f"the equalities leave one solution: {solution.fault()}"
    )
    return Outcome(
        status=status,
        values=values,
        margin=checked_margin,
        bound=checked_margin,
        multipliers={},
        tries=(),
        objective=objective,
        lower_bound=objective,
        settled=True,
        reason=reason,
    )


def lifted_outcome(free: Parametrised, outcome: Outcome) -> Outcome:
    """Return an outcome of the parametrised condition as one of the original."""
    condition = free.original
    complete = all(unknown.name in outcome.values for unknown in free.condition.unknowns)
    values = free.lifted(outcome.values) if complete else {}
    checked_margin = margin(condition, values) if values else outcome.margin
    status = outcome.status
    if status == "candidate" and not holds(condition, checked_margin):
        status = "unknown"
    offset = float(free.offset)
    objective = objective_at(condition, values)
    return replace(
        outcome,
        status=status,
        values=values,
        margin=checked_margin,
        objective=objective if values and condition.objective else outcome.objective,
        lower_bound=outcome.lower_bound + offset,
        feasible=free.lifted(outcome.feasible) if outcome.feasible else {},
    )


def refuse_kept(
    condition: Condition, assembled: Assembled | None, rows: Mapping[str, float] | None
) -> None:
    """Refuse what is given about a condition's cone data where equalities change them.

    Raises
    ------
    ModelError : cone data, or upper bounds of unknowns.
    """
    if assembled is not None or rows:
        argument = "cone data" if assembled is not None else "upper bounds of unknowns (rows)"
        raise ModelError(
            f"condition {condition.name} has equalities, and {argument} were given; pose the bound "
            "as an inequality, or give parametrised(condition).condition"
        )
