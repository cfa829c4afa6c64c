"""Where trajectories may start: ellipsoids that they do not leave, with limits and saturation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from catalogue.entry import GENERAL, Case, Entry, Sizes, plant
from takagi.lmi import Condition
from takagi.lmi.gains.attraction.condition import (
    AttractionRequest,
    attraction_condition,
    attraction_request,
)

Q = "n*(n+1)/2"
PAIRS = "r*(r+1)/2"
# Saturation has a double sum for each set of saturated inputs.
ONE_INPUT = replace(GENERAL, m=1)


def _task(sizes: Sizes, *, saturation: str | None, limit: bool) -> AttractionRequest:
    model = plant(sizes)
    return attraction_request(
        model,
        model.A,
        model.B,
        None if limit else np.ones((1, sizes.m, sizes.n)),
        state_box=np.ones(sizes.n),
        input_limit=np.ones(sizes.m) if limit else None,
        saturation=saturation,
        overdrive=10.0,
        decay_rate=0.0,
        saturated_decay_rate=0.0,
        relaxation="wang-tanaka-griffin",
        measure="trace",
        sample_time=None,
    )


def _given(sizes: Sizes) -> Condition:
    return attraction_condition(_task(sizes, saturation=None, limit=False))


def _sought(sizes: Sizes) -> Condition:
    task = _task(sizes, saturation="polytope", limit=True)
    return attraction_condition(replace(task, sought=True))


GIVEN = Entry(
    title="Region of attraction of a given loop",
    question="Which is the largest ellipsoid, inside the limits, that no trajectory leaves?",
    call="attraction_ellipsoid",
    builder="",
    use=(
        "Largest is by volume, by the trace, or by the points to contain. With gains, limits "
        "on inputs and saturation count too. Discrete time too."
    ),
    cases=(
        Case(
            title="Continuous time, one gain K for all rules, largest trace",
            pose=_given,
            lmis="r + n + 2",
            variables=Q,
            where="$P = Q^{-1}$, $\\bar x$ the half-widths of the box",
            sizes=ONE_INPUT,
        ),
    ),
)

SOUGHT = Entry(
    title="Gains of largest region of attraction under saturation",
    question="Which gains have the largest such ellipsoid though inputs saturate?",
    call="attraction_pdc",
    builder="",
    use=(
        "The saturated input is a blend of the command and of an input that keeps the limit "
        "in the ellipsoid (Hu and Lin). Discrete time too."
    ),
    cases=(
        Case(
            title="Continuous time, one input, largest trace",
            pose=_sought,
            lmis=f"2 + 2*r + 2*{PAIRS} + n",
            variables=f"{Q} + 2*r*n",
            where="$Z_i Q^{-1}$ the gains of the input that keeps its limit $\\bar u$",
            sizes=ONE_INPUT,
        ),
    ),
)

ENTRIES = (GIVEN, SOUGHT)
