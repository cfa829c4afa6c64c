"""Gains of the effort-sharing law: they serve every wind and keep torque above zero."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.lmi.turbine.effort import GROWN, EffortDesign, EffortSettings, effort_gains
from takagi.models import ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.schedule import EffortSchedule, effort_schedule
from takagi.models.ramps import effort_ramp

SETTINGS = EffortSettings()


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def schedule(turbine: Turbine) -> EffortSchedule:
    return effort_schedule(turbine)


@pytest.fixture(scope="module")
def design(turbine: Turbine, schedule: EffortSchedule) -> EffortDesign:
    return effort_gains(turbine, schedule)


def test_every_node_has_a_gain_of_short_decimals(
    schedule: EffortSchedule, design: EffortDesign
) -> None:
    gains = design.gains
    assert len(gains.proportional) == len(schedule.wind) == len(gains.integral_rate) + 1
    assert gains.proportional.min() > 0 and gains.integral_rate.min() > 0
    assert np.all(np.round(gains.proportional, 5) == gains.proportional)
    assert np.all(np.round(gains.integral_rate, 6) == gains.integral_rate)


def test_torque_stays_above_zero_on_the_operating_set(
    turbine: Turbine, schedule: EffortSchedule, design: EffortDesign
) -> None:
    """gamma e_max never uses more than the stated share of the torque left above zero."""
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    reserve = full - effort_ramp(-schedule.trim_effort, schedule.overlap)
    used = design.gains.proportional * SETTINGS.speed_error

    assert np.all(used <= SETTINGS.torque_share * reserve + 1e-6)
    limited = design.torque_limited
    assert used[limited] == pytest.approx(SETTINGS.torque_share * reserve[limited], abs=1e-6)


def test_the_effort_loop_is_stable_over_stiffness_and_inertia(design: EffortDesign) -> None:
    """e' = (a - G gamma) e + G gamma nu x_I with full gain: both poles are stable."""
    rates = design.gains.integral_rate
    for k, gamma in enumerate(design.gains.proportional):
        nu = rates[min(k, len(rates) - 1)]
        for a in design.stiffness[k]:
            for G in (1 / inertia for inertia in SETTINGS.inertia):
                loop = np.array([[a - G * gamma, G * gamma * nu], [-1.0, 0.0]])
                assert np.linalg.eigvals(loop).real.max() < 0, k


def test_the_lmi_gains_are_kept_but_for_the_torque_limit(design: EffortDesign) -> None:
    emitted, pairs = design.gains.proportional, design.gain_pairs
    assert emitted == pytest.approx(pairs[:, 0], abs=1e-5)
    rate = pairs[:, 1] / pairs[:, 0]
    slower = np.minimum(rate[:-1], rate[1:])
    assert design.gains.integral_rate == pytest.approx(slower, abs=1e-6)


@pytest.mark.slow
def test_more_bandwidth_is_more_gain(
    turbine: Turbine, schedule: EffortSchedule, design: EffortDesign
) -> None:
    slow = effort_gains(turbine, schedule, replace(SETTINGS, bandwidth=0.75 * SETTINGS.bandwidth))
    high = schedule.wind > 14

    assert np.all(slow.gains.proportional[high] < design.gains.proportional[high])


def test_a_bandwidth_that_grows_leaves_light_wind_alone(
    turbine: Turbine, schedule: EffortSchedule, design: EffortDesign
) -> None:
    """From 1.25 of the wind where pitch acts the gain grows by what is asked, or more."""
    grown = effort_gains(turbine, schedule, replace(SETTINGS, bandwidth_growth=1.5))
    begin = schedule.wind[schedule.trim_effort >= 0][0]
    ratio = grown.gains.proportional / design.gains.proportional
    low, high = schedule.wind <= begin, schedule.wind >= GROWN * begin

    assert np.array_equal(ratio[low], np.ones(low.sum()))
    assert 1.5 <= ratio[high].min() and ratio[high].max() < 1.8
    assert np.all(np.diff(ratio[~low & ~high]) > 0)


@pytest.mark.parametrize(
    "change",
    [
        {"bandwidth": 0.0},
        {"bandwidth_growth": 0.0},
        {"bandwidth": -1.0},
        {"bandwidth": float("nan")},
        {"speed_error": 0.0},
        {"torque_share": -0.1},
        {"integral_share": float("inf")},
        {"inertia": (1.1, 1.2)},
        {"inertia": (0.0, 1.0)},
    ],
    ids=str,
)
def test_settings_out_of_range_are_misuse(
    change: dict[str, Any], turbine: Turbine, schedule: EffortSchedule
) -> None:
    with pytest.raises(ModelError, match=next(iter(change))):
        effort_gains(turbine, schedule, replace(SETTINGS, **change))
