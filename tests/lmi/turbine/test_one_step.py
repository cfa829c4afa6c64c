"""Gains and functions found together: better than one after the other, and true to the loop."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from takagi.certificates.claims.turbine.cell_loop import enclosures_of_gains
from takagi.lmi.turbine.one_step.design import Objective, OneStepDesign, one_step_gains
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.models import Floats, Interval, ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    LoopBox,
    LoopUncertainty,
)
from takagi.models.laws.effort_sharing.schedule import EffortSchedule, effort_schedule

BOX = LoopBox(Fraction("0.04"), Fraction("0.008"), Fraction("0.03"), Fraction("0.03"))
UNCERTAINTY = LoopUncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


# Two-step gains of the NREL 5 MW at some winds, rounded: gamma [1/s] and nu [1/s].
WINDS = (5.2, 7.1, 8.9, 10.5, 10.9, 11.3, 11.7, 12.1, 12.9, 14.3, 18.3, 24.3)
GAMMA = (0.27, 0.357, 0.349, 0.343, 0.455, 0.584, 0.646, 0.638, 0.675, 0.686, 0.642, 0.546)
NU = (0.073, 0.085, 0.09, 0.094, 0.085, 0.096, 0.086, 0.086, 0.133, 0.175, 0.273, 0.425)


@cache
def whole_schedule() -> EffortSchedule:
    # The share that the gains below were found with.
    return effort_schedule(nrel5mw(), effectiveness_share=0.6)


def family_between(
    turbine: Turbine, low: float, high: float, *, error: float = 0.1, rate: float = 0.03
) -> LoopOfGains:
    whole = whole_schedule()
    kept = (whole.wind >= low) & (whole.wind <= high)
    columns = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
    schedule = EffortSchedule(**{c: getattr(whole, c)[kept] for c in columns}, overlap=0.01)
    nodes, middle = schedule.wind, (schedule.wind[1:] + schedule.wind[:-1]) / 2
    gains = EffortGains(np.interp(nodes, WINDS, GAMMA), np.interp(middle, WINDS, NU))
    law = EffortSharingLaw.of(turbine, schedule, gains)
    cells = len(schedule.wind) - 1
    return LoopOfGains(
        turbine=turbine,
        law=law,
        box=BOX,
        error=np.full(cells, error),
        enclosed=enclosures_of_gains(turbine, law, BOX, UNCERTAINTY, [rate] * cells),
    )


@pytest.fixture(scope="module")
def near_rated(turbine: Turbine) -> LoopOfGains:
    family = family_between(turbine, 11.4, 11.7)
    given = family.law.gains
    slow = EffortGains(given.proportional, 0.7 * given.integral_rate)
    return replace(family, law=replace(family.law, gains=slow))


@pytest.fixture(scope="module")
def given(near_rated: LoopOfGains) -> OneStepDesign:
    return one_step_gains(near_rated, steps=0)


@pytest.fixture(scope="module")
def design(near_rated: LoopOfGains) -> OneStepDesign:
    return one_step_gains(near_rated, steps=2)


def theta_of(law: EffortSharingLaw) -> Floats:
    return np.concatenate([law.gains.proportional, law.gains.integral_rate])


@pytest.mark.slow
def test_joint_steps_reach_more_than_the_gains_they_start_from(design: OneStepDesign) -> None:
    """The mean wind error grows by more than the analysis blurs, and never falls on the way."""
    errors = [reached.wind_error for reached in design.history]
    assert len(errors) > 1
    assert np.all(np.diff(errors) > 0)
    assert design.after.wind_error > 1.03 * design.before.wind_error
    assert design.before == design.history[0]


def test_the_set_is_invariant_at_the_emitted_gains(
    near_rated: LoopOfGains, design: OneStepDesign
) -> None:
    """V' < 0 on V = 1 for every corner, both signs of d, by the S-lemma written out; beyond not."""
    corners, still = near_rated.corners(theta_of(design.law))
    f = design.functions

    def worst(factor: float) -> float:
        found = -np.inf
        for A, fixed, error, k in zip(
            corners.A, corners.fixed, corners.error, corners.cell, strict=True
        ):
            d = fixed + factor * f.scales[k] * error
            M = np.zeros((4, 4))
            M[:3, :3] = f.P @ A + A.T @ f.P + f.multipliers[k] * f.P
            M[:3, 3] = M[3, :3] = f.P @ d
            M[3, 3] = -f.multipliers[k]
            root = 1 / np.sqrt(np.append(np.diag(f.P), 1.0))
            found = max(found, float(np.linalg.eigvalsh(M * np.outer(root, root))[-1]))
        return found

    assert worst(0.999) < 0 < worst(1.01)
    inside = np.linalg.inv(f.P)
    assert np.sqrt(inside[0, 0]) <= float(BOX.speed_error) * (1 + 1e-6)
    assert np.sqrt(inside[1, 1]) <= float(BOX.effort_lag) * (1 + 1e-6)
    for A in still.A:
        H = f.R @ A + A.T @ f.R + 2 * 0.999 * f.decay_rate * f.R
        assert np.linalg.eigvalsh(H)[-1] < 0


def test_gains_are_emitted_in_short_decimals(design: OneStepDesign) -> None:
    gains = design.gains
    assert np.array_equal(np.round(gains.proportional, 5), gains.proportional)
    assert np.array_equal(np.round(gains.integral_rate, 6), gains.integral_rate)


@pytest.mark.slow
def test_decay_is_an_objective_of_its_own(near_rated: LoopOfGains) -> None:
    aim = Objective(wind_class=0.0, decay=1.0)
    found = one_step_gains(near_rated, objective=aim, steps=2)
    assert found.after.decay_rate > 1.1 * found.before.decay_rate
    assert found.after.wind_error >= 0.99 * found.before.wind_error


@pytest.mark.slow
def test_no_step_at_all_is_the_analysis_of_the_given_gains(
    near_rated: LoopOfGains, given: OneStepDesign, design: OneStepDesign
) -> None:
    reached = given.before
    # The rounded gains are analysed once more, by a search that ends within 3e-3.
    assert given.after.wind_error == pytest.approx(reached.wind_error, rel=3e-3)
    assert design.before.wind_error == pytest.approx(reached.wind_error, rel=1e-6)
    gains = near_rated.law.gains
    slow = EffortGains(gains.proportional, 0.8 * gains.integral_rate)
    slower = replace(near_rated, law=replace(near_rated.law, gains=slow))
    assert one_step_gains(slower, steps=0).before.decay_rate < reached.decay_rate


def test_gains_at_an_actuators_limit_may_not_be_raised(turbine: Turbine) -> None:
    """At low wind torque ends: the family says which gains are held, and refuses them."""
    family = family_between(turbine, 5.9, 7.4)
    theta = theta_of(family.law)
    rising = theta.copy()
    for _ in range(200):
        raised = rising.copy()
        raised[: family.cells + 1] *= 1.05
        try:
            family.corners(raised)
        except ModelError:
            break
        rising = raised
    assert rising[0] > theta[0]
    _, _, free = family.moving(rising, 0.1)
    assert free[:, 0].all()
    assert not free[: family.cells + 1, 1].all()
    with pytest.raises(ModelError, match="wind cell"):
        family.corners(raised)


@pytest.mark.parametrize(
    "change",
    [
        {"wind_class": -1.0},
        {"decay": float("nan")},
        {"kept": 0.0},
        {"kept": 1.5},
        {"overspeed": float("inf")},
    ],
    ids=str,
)
def test_objectives_out_of_range_are_misuse(change: dict[str, Any]) -> None:
    with pytest.raises(ModelError, match=next(iter(change))):
        Objective(**change)


def test_misuse_is_named(near_rated: LoopOfGains) -> None:
    """No objective, a count below 0, a row of the wrong length, a class that no gains allow."""
    with pytest.raises(ModelError, match="at least one objective"):
        Objective(wind_class=0.0)
    with pytest.raises(ModelError, match="steps = -1"):
        one_step_gains(near_rated, steps=-1)
    with pytest.raises(ModelError, match="error has 7 entries"):
        replace(near_rated, error=np.ones(7))
    tiny = LoopBox(Fraction("0.0004"), Fraction("0.00008"), Fraction("0.0003"), Fraction("0.03"))
    with pytest.raises(ModelError, match="narrow the wind limits"):
        one_step_gains(replace(near_rated, box=tiny), steps=0)
