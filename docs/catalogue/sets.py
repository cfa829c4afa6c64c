"""Sets of a given loop: where it may start, what it keeps with a reference, and under noise."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import SMALL, Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    NoisyVertices,
    exit_condition,
    start_set_condition,
    tracking_condition,
)

P = "n*(n+1)/2"


def _rows(count: int, sizes: Sizes) -> np.ndarray:
    """Return rows without zeros, so that the formula shows each as a letter."""
    return np.ones((count, sizes.n)) / np.arange(1, count + 1)[:, None]


def _start(sizes: Sizes, step: float | None) -> Condition:
    return start_set_condition(
        plant(sizes, step).A, _rows(sizes.p, sizes), np.eye(sizes.n), sample_time=step
    )


def _tracking(sizes: Sizes, objective: str) -> Condition:
    rows = {objective: _rows(sizes.q, sizes)}
    return tracking_condition(
        plant(sizes).A, 0.5, _rows(sizes.p, sizes), _rows(sizes.m, sizes), **rows
    )


def _noise(sizes: Sizes) -> Condition:
    model = plant(sizes)
    system = NoisyVertices(model.A, model.B, model.E, _rows(sizes.p, sizes))
    return exit_condition(system, rate=0.5, price=1.0)


START = Entry(
    title="Set of starts",
    question="From which starts $z = N x$ does a given loop stay within limits $|r_t z| \\le 1$?",
    call="start_set",
    builder="start_set_condition",
    use=(
        "For a law with states of its own whose start is known, such as an observer at "
        "rest. The starts are $x^\\top N^\\top P N x \\le 1$. A few rounds enlarge their "
        "volume: each takes its weight $W$ from the round before and minimises "
        "$\\operatorname{trace} W N^\\top P N$. In the formula $W = N = I$."
    ),
    cases=(
        Case(
            title="Continuous time, $\\alpha = 0$",
            pose=partial(_start, step=None),
            lmis="r + p",
            variables=P,
            where="$G_k$ are the vertices, and there are $p$ limits",
        ),
        Case(
            title="Discrete time, $\\alpha = 0$",
            pose=partial(_start, step=0.1),
            lmis="r + p",
            variables=P,
            shown=False,
        ),
    ),
)

TRACKING = Entry(
    title="Tracking of a moving reference",
    question="Which set does a loop keep while its equilibrium moves with a reference?",
    call="tracking_function",
    builder="tracking_condition",
    use=(
        "$z$ is the distance from the equilibrium of the present reference, $\\lvert "
        "h_i^\\top z \\rvert \\le 1$ are the ranges of the model, $v_j$ the rates of the "
        "equilibrium, divided by $\\alpha$ and by their shares of the bound. The objective "
        "is the largest jump of the reference, or the largest error $c_k^\\top z$. See "
        "[tracking](tracking.md). Continuous time only."
    ),
    cases=(
        Case(
            title="Continuous time, largest jumps",
            pose=partial(_tracking, objective="jumps"),
            lmis="r + p + m + q",
            variables=f"{P} + 1",
            where="there are $p$ ranges, $m$ rates, and $q$ jumps $m_j$; $2\\alpha = 1$ here",
        ),
        Case(
            title="Continuous time, least error",
            pose=partial(_tracking, objective="errors"),
            lmis="r + p + m + q",
            variables=f"{P} + 1",
            shown=False,
        ),
    ),
)

NOISE = Entry(
    title="Leaving a set under white noise",
    question="How probable is it that white noise drives a loop out of a set within a time?",
    call="exit_function",
    builder="exit_condition",
    use=(
        "The probability is about $e^{-k (1 - c/a)}$, $k = 1/(2\\kappa)$; [the "
        "theorem](plant-theorems.md#theorem-of-the-exit) has the exact bound. Dinkelbach's "
        "method maximises the quotient, with a price of $\\kappa$ in the objective; $a$ is "
        "searched over. Continuous time only."
    ),
    cases=(
        Case(
            title="Continuous time, one bounded disturbance, one noise and one row $h$",
            pose=_noise,
            lmis="5",
            variables="6",
            where=(
                "$D_i$ leads from the bounded disturbance, $S_i$ from the noise; in the objective "
                "$a = 1/2$, and the price of $\\kappa$ is 1"
            ),
            sizes=SMALL,
        ),
    ),
)

ENTRIES = (START, TRACKING, NOISE)
