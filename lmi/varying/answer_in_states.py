"""From a condition on P(h) to an answer in the model's own states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.answer import Answer
from takagi.lmi.condition.evaluate import rate_of_values
from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, binding_items
from takagi.lmi.polynomials.simplex_polynomials import Basis, PolynomialLyapunov
from takagi.lmi.varying.parameter_space import VaryingLoop
from takagi.models.arrays import Floats


def decided_lyapunov(
    condition: Condition, loop: VaryingLoop, s: Floats, basis: Basis, advice: str
) -> Answer:
    """Return the answer of a condition that is posed in states xhat = x / s.

    Parameters
    ----------
    basis : of P; the coefficients are the unknown ``P``.
    advice : what to do where none exists.
    """
    outcome = decide(condition)
    good = outcome.status == "candidate"
    return replace(
        outcome.as_answer(condition, s),
        lyapunov_function=lyapunov_in_states(outcome, loop, s, basis) if good else None,
        decay_rate=rate_of_values(condition, outcome.values, loop.sample_time) if good else None,
        diagnosis="" if good else _diagnosis(condition, outcome, advice),
    )


def lyapunov_in_states(
    outcome: Outcome, loop: VaryingLoop, s: Floats, basis: Basis, size: float | None = None
) -> PolynomialLyapunov:
    """Return P(h) in the model's states, times size; None makes the least eigenvalue about 1."""
    members = outcome.values["P"]
    family = PolynomialLyapunov(basis, members, loop.space.corners)
    if size is None:
        smallest = float(np.linalg.eigvalsh(family.vertices).min())
        size = float(np.exp2(-np.floor(np.log2(smallest))))
    return PolynomialLyapunov(basis, size * members / s / s[:, None], loop.space.corners)


def no_lyapunov(condition: Condition, s: Floats, why: str) -> Answer:
    """Return the no for a reason that needs no solver."""
    return Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        coordinates=s,
        condition=condition,
        diagnosis=why,
    )


def _diagnosis(condition: Condition, outcome: Outcome, advice: str) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict]
    binding = binding_items(condition, outcome.multipliers, *names[1:])
    return f"no P(h) by these LMIs, which says nothing of others: {binding}; {advice}"
