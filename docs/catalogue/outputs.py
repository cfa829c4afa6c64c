"""Gains that are sought where not all states are seen: structured laws, and observers."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import SMALL, Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    GeneralisedPlant,
    hinf_output_feedback_condition,
    observer_condition,
    structured_pdc_condition,
)

Q = "n*(n+1)/2"
PAIRS = "r*(r+1)/2"
ROWS = (
    "$g_{aj}$, $F_{kj}$ are the rows of $G_j$ and $K_j G_j$ without their zeros, $S$ puts them in "
    "their places, $e$ are unit vectors: $\\sum_a e_a g_{aj} S_{Ga} = G_j$"
)


def _structured(sizes: Sizes, step: float | None) -> Condition:
    return structured_pdc_condition(plant(sizes, step), [[True, False]])


def _observer(sizes: Sizes, step: float | None) -> Condition:
    return observer_condition(plant(sizes, step))


STRUCTURED = Entry(
    title="Structured gains",
    question="Which gains see only some states, or outputs, or are shared by rules?",
    call="structured_pdc",
    builder="structured_pdc_condition",
    use=(
        "No exact LMI is known. In this one a slack matrix $G$ has the structure, and $Q$ is "
        "free. From it a search improves gains and $P$ in turn. The result is usually a local "
        "optimum."
    ),
    cases=(
        Case(
            title="Continuous time, two rules and states, one input that sees the first state",
            pose=partial(_structured, step=None),
            lmis="5",
            variables="11",
            where=f"{ROWS}; $\\mu > 0$ is tried",
            sizes=SMALL,
        ),
        Case(
            title="Discrete time, the same",
            pose=partial(_structured, step=0.1),
            lmis="5",
            variables="11",
            sizes=SMALL,
            shown=False,
        ),
    ),
)

OBSERVER = Entry(
    title="Observer",
    question="Which gains $L_i$ make the error of a scheduled observer decay at a given rate?",
    call="observer",
    builder="observer_condition",
    use=(
        "Compensation of the transposed model: $A_i^\\top$ and $C_i^\\top$ stand for $A_i$ "
        "and $B_i$, $Q$ is the $P$ of the error, $M_i^\\top = P L_i$. The premises are "
        "measured; with `unmeasured` the rest of the plant enters by secants."
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


ENTRIES = (STRUCTURED, OBSERVER, DYNAMIC)
