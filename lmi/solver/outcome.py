"""The best of a solver's tries, and whether its objective is near the least."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.answer import Status, Try
from takagi.lmi.term import Condition

__all__ = ["Outcome", "better", "measured", "objective_at"]

Floats = NDArray[np.float64]

# How far above its bound an objective may be to pass for the least, relative, beside what the
# second stage gave away: the bound is good to the solver's accuracy only.
NEAR = 1e-3
# Share of the sum of |cost x| below which an objective that cancels counts as zero.
CANCELLED = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The best of the tries.

    Attributes
    ----------
    status : "candidate" when the margin is positive; "infeasible" when the multipliers leave no
        room for one; "unknown" otherwise.
    values : unknown name -> (count, rows, cols).
    margin : largest t with sign F >= t weight I at ``values``, recomputed by eigenvalues.
    bound : no values have a larger t, to solver accuracy; inf when unknown.
    objective : recomputed from ``values``; nan without an objective or a candidate.
    least : no unknowns have a smaller objective, to solver accuracy; -inf when unknown.
    settled : whether the objective was minimised, and is above ``least`` by a thousandth at most
        and what the second stage gave away.  A candidate that is not settled satisfies the
        condition, and no more.
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


def better(one: Outcome, other: Outcome) -> bool:
    """Return whether it is a candidate with a smaller objective, or nearer to being one."""
    if one.status == other.status == "candidate":
        return one.objective < other.objective
    return one.status == "candidate" or (other.status != "candidate" and one.margin > other.margin)


def measured(condition: Condition, outcome: Outcome, given: float) -> Outcome:
    """Return the outcome with its objective held against the bound, ``given`` away above it."""
    costs, values = condition.objective, outcome.values
    if outcome.status != "candidate":
        return outcome
    size = sum(float(np.sum(np.abs(cost * values[name]))) for name, cost in costs.items())
    allowed = (NEAR + given) * max(abs(outcome.objective), CANCELLED * size)
    return replace(outcome, settled=outcome.objective - outcome.least <= allowed)


def objective_at(condition: Condition, values: Mapping[str, Floats]) -> float:
    if not condition.objective or not values:
        return float(np.nan)
    return float(sum(np.sum(cost * values[name]) for name, cost in condition.objective.items()))
