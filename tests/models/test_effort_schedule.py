"""The effort ramp and the schedule of the effort-sharing law: trims that meet the plant's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.models import ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.schedule import (
    EffortSchedule,
    effort_schedule,
    frozen_wake_effectiveness,
)
from takagi.models.turbine.data import rotor_torque
from takagi.models.turbine.trim import reference_speed, trim


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def schedule(turbine: Turbine) -> EffortSchedule:
    return effort_schedule(turbine)


def test_nodes_are_trims(turbine: Turbine, schedule: EffortSchedule) -> None:
    """At every node aerodynamic and generator torque balance to 1e-6 of rated torque."""
    for v, omega in zip(schedule.wind, schedule.rotor_speed, strict=True):
        driving = float(rotor_torque(turbine, omega, schedule.pitch(v, turbine), v))
        held = turbine.gear_ratio * schedule.torque(v, turbine)
        assert driving == pytest.approx(held, abs=1e-6 * turbine.gear_ratio * turbine.rated_torque)


def test_far_from_rated_the_trim_is_the_plants(turbine: Turbine, schedule: EffortSchedule) -> None:
    """Outside the overlap one actuator acts alone: torque as in trim(), then pitch as in trim()."""
    for v in (4.0, 6.0, 8.0, 10.0, 13.0, 15.0, 20.0, 25.0):
        k = int(np.argmin(np.abs(schedule.wind - v)))
        node = float(schedule.wind[k])
        if abs(schedule.trim_effort[k]) < schedule.overlap:
            continue
        point = trim(turbine, node)
        assert schedule.rotor_speed[k] == pytest.approx(point.rotor_speed, abs=1e-8)
        assert schedule.pitch(node, turbine) == pytest.approx(point.pitch, abs=1e-6)
        assert schedule.torque(node, turbine) == pytest.approx(point.torque, rel=1e-5)


def test_columns_are_short_decimals_in_order(turbine: Turbine, schedule: EffortSchedule) -> None:
    """The emitted decimals are the law: winds increase and reach cut-in and cut-out."""
    assert schedule.wind[0] == turbine.cut_in and schedule.wind[-1] == turbine.cut_out
    assert np.all(np.diff(schedule.wind) > 0)
    for column in (schedule.wind, schedule.rotor_speed, schedule.trim_effort):
        assert np.all(np.round(column, 9) == column)
    assert np.all(np.diff(schedule.trim_effort) > 0)


def test_every_kink_of_the_reference_is_a_node(turbine: Turbine, schedule: EffortSchedule) -> None:
    """Linear interpolation of omega* between nodes is exact to the rounding of the kinks' winds."""
    winds = np.linspace(turbine.cut_in, turbine.cut_out, 400)
    speeds = [reference_speed(turbine, float(v)) for v in winds]

    assert np.interp(winds, schedule.wind, schedule.rotor_speed) == pytest.approx(speeds, abs=2e-5)


def test_frozen_wake_is_the_published_sensitivity(turbine: Turbine) -> None:
    """At the published winds: dP/dbeta over rated speed and inertia; below, with v squared."""
    table = turbine.frozen_wake
    for v, power in zip(table.wind, table.power_sensitivity, strict=True):
        expected = -power / (turbine.rated_rotor_speed * turbine.inertia)
        assert frozen_wake_effectiveness(turbine, v) == pytest.approx(expected)
    first = float(table.wind[0])
    below = frozen_wake_effectiveness(turbine, first / 2)
    assert below == pytest.approx(frozen_wake_effectiveness(turbine, first) / 4)


def test_a_lower_set_point_is_followed(turbine: Turbine) -> None:
    """A de-rated set-point caps omega* and moves rated wind; nodes stay trims."""
    low = effort_schedule(turbine, speed_setpoint=1.15)

    assert low.rotor_speed.max() == pytest.approx(1.15)
    v, omega = float(low.wind[-1]), float(low.rotor_speed[-1])
    driving = float(rotor_torque(turbine, omega, low.pitch(v, turbine), v))
    assert driving == pytest.approx(turbine.gear_ratio * low.torque(v, turbine), rel=1e-6)


@pytest.mark.parametrize("options", [{"overlap": 0.0}, {"effectiveness_share": -1.0}])
def test_bad_settings_are_misuse(turbine: Turbine, options: dict[str, float]) -> None:
    """What must be positive says so."""
    with pytest.raises(ModelError, match="positive"):
        effort_schedule(turbine, **options)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"wind": np.array([2.0, 1.0])}, "increase"),
        ({"trim_effort": np.array([0.0])}, "trim_effort"),
        ({"rotor_speed": np.array([1.0, np.nan])}, "rotor_speed"),
        ({"effectiveness": np.array([1.0, 0.0])}, "positive"),
        ({"overlap": 0.0}, "positive"),
    ],
)
def test_columns_are_checked_at_the_door(change: dict[str, object], words: str) -> None:
    """Each column has one finite number per wind; the message names the column."""
    good: dict[str, object] = {
        "wind": np.array([3.0, 4.0]),
        "rotor_speed": np.ones(2),
        "trim_effort": np.zeros(2),
        "effectiveness": np.ones(2),
        "effectiveness_limit": np.ones(2),
        "overlap": 0.01,
    }
    with pytest.raises(ModelError, match=words):
        EffortSchedule(**(good | change))  # type: ignore[arg-type]


@pytest.mark.parametrize(("low", "high"), [(6.0, 25.0), (3.0, 12.0), (11.0, 25.0)])
def test_a_short_range_of_winds_has_no_node_outside(
    turbine: Turbine, low: float, high: float
) -> None:
    """Cut-in above 5 m/s, above the fine nodes, and cut-out just above rated wind."""
    wind = effort_schedule(replace(turbine, cut_in=low, cut_out=high)).wind

    assert (wind[0], wind[-1]) == (low, high)
