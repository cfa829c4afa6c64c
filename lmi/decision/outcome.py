"""What a decision returns, and the check of a solver's numbers, whatever its status says.

For a no it is not enough that the margin is bounded by a number that solvers cannot distinguish
from zero: where the entries differ much in size, the largest margin may be as small as that.  A no
needs multipliers that exclude unknowns of every size, in floating point with an allowance for all
rounding (``contradiction``), or exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from takagi.lmi.answer import Answer, Status, Try
from takagi.lmi.condition.evaluate import fractions, holds, margin
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.cone_program import Assembled, ConeProgram, Raw, in_dual_cone, margin_bound
from takagi.lmi.refutation.contradiction import contradiction
from takagi.models.arrays import Floats, ShortRepr

# How far above its bound an objective may be to pass for the least, relative, where less was asked
# for: the bound is good to the solver's accuracy only.
LARGEST_GAP = 1e-3
# What solvers cannot distinguish from zero, in unknowns of order one.
FLOOR = 2e-8


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Outcome(ShortRepr):
    """The best of the tries.

    Attributes
    ----------
    status : "candidate" when every LMI holds, the strict ones with a margin, and the objective, if
        one is minimised, is near the least; "infeasible" when multipliers leave no unknowns of
        whatever size (``answer_check``); "unbounded" when there are unknowns, ``feasible``, and a
        direction from them in which the objective falls without end; "unknown" otherwise.
    values : unknown name -> (count, rows, cols).
    margin : as ``evaluate.margin`` recomputes it from ``values``.
    bound : no values have a larger t, to solver accuracy; inf when unknown.
    objective : recomputed from ``values``; nan without an objective or a candidate, -inf where it
        is unbounded.
    lower_bound : no unknowns have a smaller objective, to solver accuracy; -inf when unknown.
    settled : whether an objective was minimised and is near ``least``: of a candidate of
        ``optimise`` always.
    feasible : the unknowns of an outcome that is "unknown" or "unbounded" although they satisfy
        the condition, because their objective is not near the least; else empty.
    reason : why it is no candidate, with the numbers, where that is known; else empty.
    """

    status: Status
    values: Mapping[str, Floats]
    margin: float
    bound: float
    multipliers: Mapping[str, Floats]
    tries: tuple[Try, ...]
    objective: float = np.nan
    lower_bound: float = -np.inf
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


def better(first: Outcome, second: Outcome) -> bool:
    """Return whether it is a candidate with a smaller objective, or nearer to being one."""
    if first.status == second.status == "candidate":
        return first.objective < second.objective
    return first.status == "candidate" or (
        second.status != "candidate" and first.margin > second.margin
    )


def promised(slack: float) -> float:
    """Return how far above the least an objective is at most, relative, where it was minimised."""
    return max(slack, LARGEST_GAP)


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
    if not np.isfinite(outcome.lower_bound):
        return replace(outcome, settled=False)
    allowed = max(promised(slack) * abs(outcome.lower_bound), nothing(condition))
    return replace(outcome, settled=outcome.objective - outcome.lower_bound <= allowed)


def concluded(outcome: Outcome) -> Outcome:
    """Return the outcome of a minimisation: a candidate that is not settled is "unknown"."""
    if outcome.status != "candidate" or outcome.settled:
        return outcome
    return replace(
        outcome,
        status="unknown",
        feasible=outcome.values,
        reason=not_least(outcome.objective, outcome.lower_bound),
    )


def not_least(value: float, lower_bound: float) -> str:
    """Return in words that an objective is not near its bound, with both numbers."""
    bound = (
        f"the least is no less than {lower_bound:.5g}"
        if np.isfinite(lower_bound)
        else "no bound is known"
    )
    return f"no solver came near the least one: {value:.5g} was found, {bound}"


def objective_at(condition: Condition, values: Mapping[str, Floats]) -> float:
    if not condition.objective or not values:
        return float(np.nan)
    return float(sum(np.sum(cost * values[name]) for name, cost in condition.objective.items()))


# Items with less of the bound than this are not reported.
SMALLEST_SHARE = 0.02


class Share(NamedTuple):
    """How much of the bound on the margin an item carries: its label, its LMI, and 0 ... 1."""

    label: str
    lmi: str
    share: float


def binding_items(
    condition: Condition, multipliers: Mapping[str, Floats], *names: str, most: int = 3
) -> str:
    """Return e.g. ``"the no rests on vertex 2 of 8 (61% of the multipliers that show it)"``.

    ``names`` : the LMIs to examine.
    """
    shares = binding_shares(condition, multipliers, *names)
    if not shares:
        return "the no depends on no single inequality"
    return f"the no rests on {shares_in_words(shares[:most])}"


def asks_for_decay(condition: Condition) -> bool:
    """Return whether a decay rate above 0 is asked for, which might be lowered."""
    parameters = condition.parameters
    if not {"alpha", "contraction"} & set(parameters):
        return True  # the rate is not a parameter of the condition
    return parameters.get("alpha", 0.0) > 0 or parameters.get("contraction", 1.0) < 1


def advice_about_limit(condition: Condition) -> str:
    """Return what to change a little where a condition is at its limit."""
    if asks_for_decay(condition):
        return "lower the decay rate a little"
    return "shrink the box a little"


def shares_in_words(shares: Sequence[Share]) -> str:
    """Return labels with their shares; what these are shares of stands behind the first.

    Multipliers show the no: an item without any could be left out, and it would still be no.
    """
    first = f"{shares[0].label} ({shares[0].share:.0%} of the multipliers that show it)"
    return ", ".join([first, *(f"{share.label} ({share.share:.0%})" for share in shares[1:])])


def binding_shares(
    condition: Condition, multipliers: Mapping[str, Floats], *names: str
) -> tuple[Share, ...]:
    """Return the items that carry more than 2% of the bound on the margin, largest first.

    The trace of an item's multiplier times the item's size is its share in the bound on the
    margin: items without a share could be left out and the answer would still be no.

    ``names`` : the LMIs to examine; without names, all that have a weight.
    """
    shares = []
    for lmi in condition.lmis:
        if lmi.name in multipliers and (lmi.name in names or (not names and lmi.strict)):
            traces = _size(lmi) * np.trace(multipliers[lmi.name], axis1=1, axis2=2)
            shares += [Share(lmi.label(k), lmi.name, float(t)) for k, t in enumerate(traces)]
    total = sum(share.share for share in shares)
    if total <= 0:
        return ()
    # A stable order: of equal shares the first item is named first.
    shares.sort(key=lambda share: -share.share)
    return tuple(
        share._replace(share=share.share / total)
        for share in shares
        if share.share > SMALLEST_SHARE * total
    )


def _size(lmi: LMI) -> float:
    """Return the natural size of an LMI: its weight, or that of its constants."""
    constants = (float(np.abs(c.value.astype(np.float64)).max()) for c in lmi.constants)
    return max(lmi.weight, *constants, 0.0)


# What the solver's tolerances can distinguish from zero.
SMALLEST_BOUND = 1e-7
# Where no LMI is strict, the bound on the margin must be below minus this for a no: an LMI may
# be violated by its tolerance and still count as satisfied.
NONSTRICT_TOLERANCE = 1e-5
# How far the objective is followed where it falls without end, in units of its size.
DISTANCES = (1e3, 1e6)
# Entries of multipliers up to which a no is sought in exact arithmetic: about a second.
EXACT = 1200


def judged(data: Assembled, program: ConeProgram, raw: Raw) -> Outcome:
    """Check the solver's numbers from scratch; its status is not read."""
    outcome = weighed(data, program, raw)
    if outcome.status == "unknown" and says_no(data, outcome) and _excluded(data, program, raw):
        return replace(outcome, status="infeasible")
    return outcome


def weighed(data: Assembled, program: ConeProgram, raw: Raw) -> Outcome:
    """Return the same without a search for a no: what is no candidate is "unknown"."""
    values = values_of(data, raw)
    checked_margin = margin(data.condition, values) if values else -np.inf
    bound, packed = margin_bound(program, raw)
    multipliers = data.multipliers(packed) if len(packed) else {}
    status: Status = "candidate" if holds(data.condition, checked_margin) else "unknown"
    return Outcome(status, values, checked_margin, bound, multipliers, ())


def says_no(data: Assembled, outcome: Outcome) -> bool:
    """Return whether the bound on the margin is one that may leave none."""
    strict = any(lmi.strict for lmi in data.condition.lmis)
    return outcome.bound < (SMALLEST_BOUND if strict else -NONSTRICT_TOLERANCE)


def exactly_judged(condition: Condition, outcome: Outcome) -> Outcome:
    """Return a no where exact multipliers exclude every solution; what is given where none do."""
    from takagi.lmi.refutation.refutation import exact_no

    entries = sum(lmi.count * triangle(lmi.size) for lmi in condition.lmis)
    refutation = exact_no(condition, outcome.multipliers) if entries <= EXACT else None
    if refutation is None:
        return outcome
    exact = {name: value.astype(np.float64) for name, value in refutation.multipliers.items()}
    return replace(outcome, status="infeasible", multipliers={**outcome.multipliers, **exact})


def exactly_held(condition: Condition, outcome: Outcome) -> Outcome:
    """Return a candidate where the unknowns satisfy every LMI in exact arithmetic.

    For a margin that is positive and too small for floating point: entries of an LMI, or the LMIs
    of several vertices, may differ by 1e10 in size.
    """
    from takagi.lmi.equalities import ExactSolution

    entries = sum(lmi.count * triangle(lmi.size) for lmi in condition.lmis)
    if not (
        outcome.status == "unknown" and outcome.values and outcome.margin > 0 and entries <= EXACT
    ):
        return outcome
    exact = {name: fractions(value) for name, value in outcome.values.items()}
    is_exact = ExactSolution(condition=condition, values=exact).holds
    return replace(outcome, status="candidate") if is_exact else outcome


def falling(data: Assembled, raw: Raw, start: Outcome) -> Outcome | None:
    """Return "unbounded" where the objective falls without end from ``start``; None if not seen.

    The solver's y is then a direction.  Each LMI is evaluated far along it, so its status decides
    nothing.
    """
    direction = values_of(data, raw)
    down = objective_at(data.condition, direction)
    if start.status != "candidate" or not down < 0:
        return None
    size = max(1.0, abs(objective_at(data.condition, start.values)))
    for distance in DISTANCES:
        step = distance * size / -down
        shifted = {name: value + step * direction[name] for name, value in start.values.items()}
        if not holds(data.condition, margin(data.condition, shifted)):
            return None
    return replace(
        start,
        status="unbounded",
        values={},
        feasible=start.values,
        objective=-np.inf,
        reason="the objective has no least value: it falls without end; bound its unknowns",
    )


def _excluded(data: Assembled, program: ConeProgram, raw: Raw) -> bool:
    """Return whether the multipliers leave no unknowns, of any size.

    Without a strict LMI the bound is what it rests on: the weights are those of the tolerances.
    """
    if not any(lmi.strict for lmi in data.condition.lmis):
        return True
    return contradiction(program, in_dual_cone(program, raw.z)) is not None


def values_of(data: Assembled, raw: Raw) -> dict[str, Floats]:
    """Return the unknowns, or nothing where there are no finite numbers for all of them."""
    usable = len(raw.y) >= len(data.objective) and bool(np.all(np.isfinite(raw.y)))
    return data.values(raw.y) if usable else {}
