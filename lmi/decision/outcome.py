"""The best of a solver's tries, and whether its objective is near the least."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.answer import Answer, Status, Try
from takagi.lmi.condition.term import Condition
from takagi.models.arrays import Floats

# How far above its bound an objective may be to pass for the least, relative, where less was asked
# for: the bound is good to the solver's accuracy only.
NEAR = 1e-3
# What solvers cannot distinguish from zero, in unknowns of order one.
FLOOR = 2e-8


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The best of the tries.

    Attributes
    ----------
    status : "candidate" when every LMI holds, the strict ones with a margin, and the objective, if
        one is minimised, is near the least; "infeasible" when multipliers leave no unknowns of
        whatever size (``answer_check``); "unknown" otherwise.
    values : unknown name -> (count, rows, cols).
    margin : as ``evaluate.margin`` recomputes it from ``values``.
    bound : no values have a larger t, to solver accuracy; inf when unknown.
    objective : recomputed from ``values``; nan without an objective or a candidate.
    least : no unknowns have a smaller objective, to solver accuracy; -inf when unknown.
    settled : whether an objective was minimised and is near ``least``: of a candidate of
        ``optimise`` always.
    feasible : the unknowns of an outcome that is "unknown" although they satisfy the condition,
        because their objective is not near the least; else empty.
    reason : why it is "unknown", with both numbers, where that is known; else empty.
    """

    status: Status
    values: Mapping[str, Floats]
    margin: float
    bound: float
    multipliers: Mapping[str, Floats]
    tries: tuple[Try, ...]
    objective: float = np.nan
    least: float = -np.inf
    settled: bool = False
    feasible: Mapping[str, Floats] = field(default_factory=dict)
    reason: str = ""

    def as_answer(self, condition: Condition, coordinates: Floats | None) -> Answer:
        """Return the outcome as an answer that shows no P yet and gives no diagnosis."""
        return Answer(
            status=self.status,
            margin=self.margin,
            bound=self.bound,
            values=self.values,
            multipliers=self.multipliers,
            coordinates=coordinates,
            condition=condition,
            tries=self.tries,
        )

    def unsettled(self, advice: str) -> str:
        """Return in words that nothing was decided, and what to do."""
        return (
            f"no solver settled it: the best margin was {self.margin:.2g}, the bound on it "
            f"{self.bound:.2g}; the condition is at its limit or badly scaled: {advice}"
        )


def better(one: Outcome, other: Outcome) -> bool:
    """Return whether it is a candidate with a smaller objective, or nearer to being one."""
    if one.status == other.status == "candidate":
        return one.objective < other.objective
    return one.status == "candidate" or (other.status != "candidate" and one.margin > other.margin)


def promised(slack: float) -> float:
    """Return how far above the least an objective is at most, relative, where it was minimised."""
    return max(slack, NEAR)


def nothing(condition: Condition) -> float:
    """Return the objective that no solver can distinguish from zero."""
    costs = condition.objective.values()
    return FLOOR * max((float(np.abs(cost).max(initial=0.0)) for cost in costs), default=0.0)


def measured(condition: Condition, outcome: Outcome, slack: float) -> Outcome:
    """Return the outcome with its objective compared with the bound.

    It is settled where the gap between them is at most ``promised(slack)`` of the *bound*, or
    cannot be distinguished from zero by a solver.  A share of the objective itself would measure
    nothing: an objective far too large is near its bound by its own size.
    """
    if outcome.status != "candidate":
        return outcome
    if not np.isfinite(outcome.least):
        return replace(outcome, settled=False)
    allowed = max(promised(slack) * abs(outcome.least), nothing(condition))
    return replace(outcome, settled=outcome.objective - outcome.least <= allowed)


def concluded(outcome: Outcome) -> Outcome:
    """Return the outcome of a minimisation: a candidate that is not settled is "unknown"."""
    if outcome.status != "candidate" or outcome.settled:
        return outcome
    return replace(
        outcome,
        status="unknown",
        feasible=outcome.values,
        reason=not_least(outcome.objective, outcome.least),
    )


def not_least(found: float, least: float) -> str:
    """Return in words that an objective is not near its bound, with both numbers."""
    bound = f"the least is no less than {least:.5g}" if np.isfinite(least) else "no bound is known"
    return f"no solver came near the least one: {found:.5g} was found, {bound}"


def objective_at(condition: Condition, values: Mapping[str, Floats]) -> float:
    if not condition.objective or not values:
        return float(np.nan)
    return float(sum(np.sum(cost * values[name]) for name, cost in condition.objective.items()))
