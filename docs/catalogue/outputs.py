"""Observers."""

from __future__ import annotations

from functools import partial

from catalogue.entry import Case, Entry, Sizes, plant
from takagi.lmi import Condition, observer_condition

Q = "n*(n+1)/2"
PAIRS = "r*(r+1)/2"


def _observer(sizes: Sizes, step: float | None) -> Condition:
    return observer_condition(plant(sizes, step))


OBSERVER = Entry(
    title="Observer",
    question="Which gains $L_i$ make the error of a scheduled observer decay at a given rate?",
    call="observer",
    builder="observer_condition",
    use=(
        "Compensation of the transposed model: $A_i^\\top$ and $C_i^\\top$ stand for $A_i$ "
        "and $B_i$, $Q$ is the $P$ of the error, $M_i^\\top = P L_i$. The premises are "
        "measured."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_observer, step=None),
            lmis=f"r + 2 + {PAIRS}",
            variables=f"{Q} + r*n*p + 1",
            shown=False,
        ),
        Case(
            title="Discrete time",
            pose=partial(_observer, step=0.1),
            lmis=f"r + 2 + {PAIRS}",
            variables=f"{Q} + r*n*p + 1",
            shown=False,
        ),
    ),
)


ENTRIES = (OBSERVER,)
