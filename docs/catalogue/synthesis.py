"""Gains that are sought: of a law that sees all states."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import FEW, Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    fuzzy_pdc_condition,
    h2_pdc_condition,
    hinf_pdc_condition,
    lqr_pdc_condition,
    pdc_condition,
    peak_pdc_condition,
)
from takagi.lmi.gains.requirements.limits import limits_of

Q = "n*(n+1)/2"
# All pairs of rules.
PAIRS = "r*(r+1)/2"


def _pdc(sizes: Sizes, step: float | None) -> Condition:
    return pdc_condition(plant(sizes, step))


def _limited(sizes: Sizes) -> Condition:
    limits = limits_of(
        sizes.n,
        sizes.m,
        input_limit=np.ones(sizes.m),
        initial_box=None,
        state_box=np.ones(sizes.n),
        gain_bound=1.0,
    )
    return pdc_condition(plant(sizes), limits=limits)


def _cost(sizes: Sizes, step: float | None) -> Condition:
    return lqr_pdc_condition(plant(sizes, step), np.eye(sizes.n), np.eye(sizes.m))


def _energy(sizes: Sizes, step: float | None) -> Condition:
    return hinf_pdc_condition(plant(sizes, step))


def _variance(sizes: Sizes, step: float | None, form: str = "energy") -> Condition:
    return h2_pdc_condition(plant(sizes, step), form=form)


def _peak(sizes: Sizes, step: float | None) -> Condition:
    return peak_pdc_condition(plant(sizes, step), decay_rate=0.1)


def _fuzzy(sizes: Sizes, step: float | None) -> Condition:
    return fuzzy_pdc_condition(plant(sizes, step), rate_bounds=None if step else 1.0)


PDC = Entry(
    title="Parallel distributed compensation",
    question="Which gains of $u = -\\sum_i h_i K_i x$ make every blend decay at a given rate?",
    call="pdc",
    builder="pdc_condition",
    use=(
        "Of all possible gains $K_i = M_i Q^{-1}$, $P = Q^{-1}$, those of least input "
        "effort $\\nu$. Options: limits on input, state and gains, a `region` for the "
        'eigenvalues, and the `relaxation`; `"auto"` climbs from cheap to rich.'
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_pdc, step=None),
            lmis=f"r + 2 + {PAIRS}",
            variables=f"{Q} + r*m*n + 1",
        ),
        Case(
            title="Discrete time",
            pose=partial(_pdc, step=0.1),
            lmis=f"r + 2 + {PAIRS}",
            variables=f"{Q} + r*m*n + 1",
        ),
        Case(
            title="With limits on inputs, states and gains",
            pose=_limited,
            lmis=f"r + 2 + {PAIRS} + r*m + n + 1 + r",
            variables=f"{Q} + r*m*n + 2",
            shown=False,
        ),
    ),
)

COST = Entry(
    title="Guaranteed quadratic cost",
    question="Which gains have the least bound on $\\int x^\\top Q x + u^\\top R u \\; dt$?",
    call="lqr_pdc",
    builder="lqr_pdc_condition",
    use=(
        "Of one rule it is the linear-quadratic regulator. The mean cost over random $x(0)$ "
        "is least. In discrete time the cost is a sum."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_cost, step=None),
            lmis=f"1 + {PAIRS}",
            variables=f"2*{Q} + r*m*n",
            where=(
                "$S = P^{-1}$, weights $Q = F^\\top F$, $R = G^\\top G$, and $x(0)$ of covariance "
                "$L L^\\top$"
            ),
        ),
        Case(
            title="Discrete time",
            pose=partial(_cost, step=0.1),
            lmis=f"1 + {PAIRS}",
            variables=f"2*{Q} + r*m*n",
            shown=False,
        ),
    ),
)

HINF = Entry(
    title="Gains of least energy gain",
    question="Which gains make the energy of the output least, per energy of the disturbance?",
    call="hinf_pdc",
    builder="hinf_pdc_condition",
    use=(
        "H-infinity state feedback for every blend, however the memberships move. The least "
        "$\\gamma$ often needs ever larger gains; `tolerance` leaves room."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_energy, step=None),
            lmis=f"1 + {PAIRS}",
            variables=f"{Q} + r*m*n + 1",
            where="$z = C x + D^{12} u + D^{11} w$",
        ),
        Case(
            title="Discrete time",
            pose=partial(_energy, step=0.1),
            lmis=f"1 + {PAIRS}",
            variables=f"{Q} + r*m*n + 1",
            shown=False,
        ),
    ),
)

H2 = Entry(
    title="Gains of least output variance",
    question="Which gains make the mean square of the output under white noise least?",
    call="h2_pdc",
    builder="h2_pdc_condition",
    use=(
        'H2 state feedback for every blend; of one rule the H2 optimum. `form="gramian"` is '
        "often less where $E$ differs between rules; it holds for white noise and "
        "memberships that do not depend on it."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_variance, step=None),
            lmis=f"2*r + 1 + {PAIRS}",
            variables=f"{Q} + r*m*n + r*q*(q+1)/2 + 1",
            where="$e_k$ unit vectors, so that the sum is the trace of $W_i$",
        ),
        Case(
            title="Discrete time",
            pose=partial(_variance, step=0.1),
            lmis=f"2*r + 1 + {PAIRS}",
            variables=f"{Q} + r*m*n + r*q*(q+1)/2 + 1",
            shown=False,
        ),
        Case(
            title='Form "gramian", continuous time',
            pose=partial(_variance, step=None, form="gramian"),
            lmis=f"r + 1 + 2*{PAIRS}",
            variables=f"{Q} + r*m*n + r*p*(p+1)/2 + 1",
            shown=False,
        ),
        Case(
            title='Form "gramian", discrete time',
            pose=partial(_variance, step=0.1, form="gramian"),
            lmis=f"r + 1 + 2*{PAIRS}",
            variables=f"{Q} + r*m*n + r*p*(p+1)/2 + 1",
            shown=False,
        ),
    ),
)

PEAK = Entry(
    title="Gains of least peak",
    question="Which gains keep the output smallest under a disturbance of bounded size?",
    call="peak_pdc",
    builder="peak_pdc_condition",
    use=(
        "As `peak_gain`, by two double sums in $Q = P^{-1}$ and $M_i = K_i Q$; $\\alpha$ is "
        "searched over."
    ),
    cases=(
        Case(
            title="Continuous time, at one rate",
            pose=partial(_peak, step=None),
            lmis=f"1 + 2*{PAIRS}",
            variables=f"{Q} + r*m*n + 1",
            shown=False,
        ),
        Case(
            title="Discrete time, at one rate",
            pose=partial(_peak, step=0.1),
            lmis=f"1 + 2*{PAIRS}",
            variables=f"{Q} + r*m*n + 1",
            shown=False,
        ),
    ),
)

FUZZY = Entry(
    title="Compensation with a Lyapunov matrix for each rule",
    question="Which gains are there with $V = x^\\top P(h) x$?",
    call="fuzzy_pdc",
    builder="fuzzy_pdc_condition",
    use=(
        "Where `pdc` finds none. Continuous time needs bounds on the rates of the "
        "memberships, and searches over $\\epsilon$; discrete time needs none."
    ),
    cases=(
        Case(
            title="Continuous time, two rules",
            pose=partial(_fuzzy, step=None),
            variables=f"r*{Q} + n*n + r*m*n + 1",
            where=(
                "$c = \\kappa / \\sqrt{\\epsilon}$, $d = \\sqrt{\\epsilon}$, and $\\dot h$ a "
                "corner of the rates"
            ),
            sizes=FEW,
        ),
        Case(
            title="Discrete time, two rules",
            pose=partial(_fuzzy, step=0.1),
            variables=f"r*{Q} + n*n + r*m*n + 1",
            sizes=FEW,
            shown=False,
        ),
    ),
)

ENTRIES = (PDC, COST, HINF, H2, PEAK, FUZZY)
