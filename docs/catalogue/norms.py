"""Gains from a disturbance to an output of a given loop."""

from __future__ import annotations

from functools import partial

from catalogue.entry import Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    h2_norm_condition,
    hinf_norm_condition,
    peak_gain_condition,
)

P = "n*(n+1)/2"


def _energy(sizes: Sizes, step: float | None) -> Condition:
    return hinf_norm_condition(plant(sizes, step))


def _variance(sizes: Sizes, step: float | None) -> Condition:
    return h2_norm_condition(plant(sizes, step))


def _peak(sizes: Sizes, step: float | None) -> Condition:
    return peak_gain_condition(plant(sizes, step), decay_rate=0.1)


HINF = Entry(
    title="Energy gain (H-infinity norm)",
    question="How much energy can the output have per energy of the disturbance?",
    call="hinf_norm",
    builder="hinf_norm_condition",
    use=(
        "For disturbances of finite energy, and by the small-gain theorem for neglected "
        "dynamics. Of one vertex it is the H-infinity norm; of several an upper bound, "
        "however the memberships move. The disturbance enters by `E`, or by the input where "
        "there is none."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_energy, step=None),
            lmis="r + 1",
            variables=f"{P} + 1",
            where="$B_i$, $C_i$, $D_i$ lead from the disturbance to the output",
        ),
        Case(
            title="Discrete time",
            pose=partial(_energy, step=0.1),
            lmis="r + 1",
            variables=f"{P} + 1",
            shown=False,
        ),
    ),
)

H2 = Entry(
    title="Output variance (H2 norm)",
    question="How large is the mean square of the output under white noise?",
    call="h2_norm",
    builder="h2_norm_condition",
    use=(
        "For noise, and for the energy of impulse responses. Of one vertex it is the H2 "
        "norm; of several an upper bound for every blend. In continuous time the "
        "disturbance must not enter the output directly."
    ),
    cases=(
        Case(
            title="Continuous time",
            pose=partial(_variance, step=None),
            lmis="2*r + 1",
            variables=f"{P} + 1",
            where="$b_{ik}$ the columns of the disturbance's matrix",
        ),
        Case(
            title="Discrete time",
            pose=partial(_variance, step=0.1),
            lmis="2*r + 1",
            variables=f"{P} + 1",
            shown=False,
        ),
    ),
)

PEAK = Entry(
    title="Peak-to-peak gain",
    question="How large can the output become under a disturbance of bounded size?",
    call="peak_gain",
    builder="peak_gain_condition",
    use=(
        "An upper bound, by an ellipsoid that no trajectory leaves, for disturbances that "
        "persist; $\\alpha$ is searched over. Of one vertex it bounds the L1 norm of the "
        "impulse response."
    ),
    cases=(
        Case(
            title="Continuous time, at one rate",
            pose=partial(_peak, step=None),
            lmis="2*r",
            variables=f"{P} + 2",
        ),
        Case(
            title="Discrete time, at one rate",
            pose=partial(_peak, step=0.1),
            lmis="2*r",
            variables=f"{P} + 2",
            shown=False,
        ),
    ),
)

ENTRIES = (HINF, H2, PEAK)
