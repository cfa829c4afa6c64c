"""Check of a solver's numbers from scratch, whatever its status says.

For a no it is not enough that the margin is bounded by a number that solvers cannot distinguish
from zero: where the entries differ much in size, the largest margin may be as small as that.  A no
needs multipliers that exclude unknowns of every size, in floating point with an allowance for all
rounding (``contradiction``), or exact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.answer import Status
from takagi.lmi.condition.evaluate import fractions, holds, margin
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.assemble import Assembled
from takagi.lmi.cone.duality import in_dual_cone, margin_bound
from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.lmi.decision.outcome import Outcome, objective_at
from takagi.lmi.refutation.contradiction import contradiction
from takagi.models.arrays import Floats

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
    from takagi.lmi.equalities.exact_solution import ExactSolution

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
