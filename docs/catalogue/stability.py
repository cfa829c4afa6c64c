"""Stability, decay and regions of a given loop."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import FEW, Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    EigenvalueRegion,
    common_lyapunov_condition,
    d_stability_condition,
    fuzzy_lyapunov_condition,
)

P = "n*(n+1)/2"


def _common(sizes: Sizes, step: float | None) -> Condition:
    return common_lyapunov_condition(plant(sizes, step))


def _region(sizes: Sizes) -> Condition:
    region = (
        EigenvalueRegion.half_plane(1)
        & EigenvalueRegion.disc(9)
        & EigenvalueRegion.sector(np.pi / 6)
    )
    return d_stability_condition(plant(sizes), region)


def _fuzzy(sizes: Sizes, step: float | None) -> Condition:
    return fuzzy_lyapunov_condition(plant(sizes, step), rate_bounds=np.inf if step else 1.0)


COMMON = Entry(
    title="Common quadratic Lyapunov function",
    question="Does one $V = x^\\top P x$ decay at a given rate along every blend of the vertices?",
    call="common_lyapunov",
    builder="common_lyapunov_condition",
    use=(
        "The first thing to ask of a closed loop. The memberships may move in any way. No "
        "common $P$ does not mean unstable. `max_decay_rate` finds the largest $\\alpha$, a "
        "generalised eigenvalue."
    ),
    cases=(
        Case(title="Continuous time", pose=partial(_common, step=None), lmis="r + 2", variables=P),
        Case(
            title="Discrete time",
            pose=partial(_common, step=0.1),
            lmis="r + 2",
            variables=P,
        ),
    ),
)

REGION = Entry(
    title="Eigenvalues in a region (D-stability)",
    question="Does every frozen blend have all its eigenvalues in a region of the complex plane?",
    call="d_stability",
    builder="d_stability_condition",
    use=(
        "Half-planes, strips, discs, sectors, any LMI region (an ellipse, a parabola), and "
        "intersections by `&`. It is about constant memberships; for varying ones only the "
        "decay rate follows."
    ),
    cases=(
        Case(
            title="For the region Re z < -1, |z| < 9, |arg(-z)| < 30°",
            pose=_region,
            lmis="3*r + 2",
            variables=P,
        ),
    ),
)

FUZZY = Entry(
    title="Fuzzy Lyapunov function with bounded rates",
    question="Does $V = x^\\top P(h) x$ decay while the rates of the memberships are bounded?",
    call="fuzzy_lyapunov",
    builder="fuzzy_lyapunov_condition",
    use=(
        "Where there is no common $P$, and bounds on $\\lvert\\dot z_k\\rvert$ (with premises) "
        "or $\\lvert\\dot h_i\\rvert$ (without) are known; `inf` for none, 0 for constants: "
        "with growing `degree` every stable family is found then. In discrete time steps may be "
        "free. The bounds are assumptions about the loop: check that it keeps "
        "them. `relaxation` chooses among published forms."
    ),
    cases=(
        Case(
            title="Continuous time, two rules",
            pose=partial(_fuzzy, step=None),
            variables=f"r*{P}",
            where=(
                "$\\dot P(h)$ is taken at every corner of the rates: $2^k$ for $k$ premises, more "
                "with every rule"
            ),
            sizes=FEW,
        ),
        Case(
            title="Discrete time, steps of any size, two rules",
            pose=partial(_fuzzy, step=0.1),
            variables=f"r*{P}",
            sizes=FEW,
            shown=False,
        ),
    ),
)

ENTRIES = (COMMON, REGION, FUZZY)
