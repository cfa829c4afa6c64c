"""The result of a structured design: gains, their value, and the loss due to the structure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.answer import Answer, GainsWithAnswer
from takagi.lmi.gains.structured.joint_steps import StepSearch, StructuredPoint
from takagi.lmi.gains.structured.local_search import LocalSearch, LocalStep
from takagi.lmi.gains.structured.sums import Objective
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StructuredDesign(GainsWithAnswer):
    """Structured gains, their value, and the loss due to the structure.

    Attributes
    ----------
    gains : (r, m, n), K_i = F_i C for u = -sum_i h_i K_i x; None unless found.
    output_gains : (r, m, p), F_i for u = -sum_i h_i F_i C x, exactly zero off the pattern.
    P : (n, n) for V = x' P x; None unless found.
    objective : "decay_rate", "cost" or "hinf".
    value : decay rate in 1/s, mean cost, or gamma, that P shows for these gains.
    unstructured : the best value known without the structure, one gain a rule; nan if unknown.
    loss : relative loss of the value due to the structure, at least 0: 1 - value / unstructured of
        a decay rate, value / unstructured - 1 of a cost or gamma.
    relaxation : name of the double-sum relaxation.
    steps : the accepted steps from all starts, in order.
    answer : the answer of the last LMI, in which the returned gains are fixed and P is unknown.
    """

    gains: Floats | None = None
    output_gains: Floats | None = None
    P: Floats | None = None
    objective: Objective
    value: float
    unstructured: float
    loss: float
    relaxation: str
    steps: tuple[LocalStep, ...]
    answer: Answer


def found_at(
    search: StepSearch, spot: StructuredPoint, unstructured: float, local: LocalSearch
) -> StructuredDesign:
    """Return the design of the best spot.

    Parameters
    ----------
    unstructured : the best value known without the structure.
    """
    value = spot.value
    ratio = value / unstructured
    P = spot.P
    if search.objective == "decay_rate":
        # A decay rate does not depend on the size of P: the least eigenvalue is brought to 1 ... 2,
        # by a power of two, which rounds no entry.
        P = P / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    answer = replace(
        spot.outcome.as_answer(spot.condition, None),
        status="candidate",
        P=P,
        decay_rate=value if search.objective == "decay_rate" else None,
        gain=value if search.objective == "hinf" else None,
        tries=tuple(search.tries),
    )
    return StructuredDesign(
        gains=search.structure.gains(spot.F),
        output_gains=spot.F[search.structure.group],
        P=P,
        objective=search.objective,
        value=value,
        unstructured=unstructured,
        loss=1.0 - ratio if search.sense > 0 else ratio - 1.0,
        relaxation=search.relaxation,
        steps=tuple(local.steps),
        answer=answer,
    )


def unsettled(local: LocalSearch) -> Answer:
    """Return the answer for the case that no start led to a stable loop."""
    rate = local.reached()
    return Answer(
        status="unknown",
        margin=-np.inf,
        diagnosis=(
            f"from no start were gains of this structure found; the largest decay rate of one "
            f"quadratic function was {rate:.6g} 1/s: let the law see more, share fewer gains, "
            "raise gain_bound, shrink the box, or take a richer relaxation"
        ),
        tries=tuple(local.search.tries),
    )


def without(search: StepSearch, answer: Answer, steps: tuple[LocalStep, ...]) -> StructuredDesign:
    """Return a design without gains."""
    return StructuredDesign(
        objective=search.objective,
        value=float("nan"),
        unstructured=float("nan"),
        loss=float("nan"),
        relaxation=search.relaxation,
        steps=steps,
        answer=answer,
    )
