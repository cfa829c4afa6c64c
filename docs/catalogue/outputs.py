"""Observers, and controllers that see an output alone."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    GeneralisedPlant,
    hinf_output_feedback_condition,
    observer_condition,
)

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


def _dynamic(sizes: Sizes) -> Condition:
    n, m, p, q = sizes.n, sizes.m, sizes.p, sizes.q
    # As many weighted signals as disturbances.
    return hinf_output_feedback_condition(
        GeneralisedPlant(
            A=-np.eye(n) + np.eye(n, k=1),
            B1=np.eye(n, q),
            B2=np.eye(n, m) / 2,
            C1=np.eye(q, n),
            C2=np.eye(p, n) / 2,
            D11=np.eye(q) / 4 + np.eye(q, k=1),
            D12=np.eye(q, m) / 8,
            D21=np.eye(p, q) / 8,
        )
    )


DYNAMIC = Entry(
    title="Energy gain by dynamic output feedback",
    question="Which dynamic controller has the least H-infinity norm?",
    call="hinf_output_feedback",
    builder="hinf_output_feedback_condition",
    use=(
        "For one linear plant whose states are not measured; `mixed_sensitivity` makes it of a "
        "loop and its weights. The least $\\gamma$ is that of all linear controllers. Continuous "
        "time only."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=_dynamic,
            lmis="2",
            variables="2*n*(n+1)/2 + n*n + n*p + m*n + m*p + 1",
            where=(
                "$\\dot x = A x + B_1 w + B_2 u$, $z = C_1 x + D_{11} w + D_{12} u$, "
                "$y = C_2 x + D_{21} w$, and $z$ is as wide as $w$"
            ),
        ),
    ),
)


ENTRIES = (OBSERVER, DYNAMIC)
