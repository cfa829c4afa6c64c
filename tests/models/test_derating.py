"""De-rated operation: power, trim and schedule at a lower torque, and what is refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

from takagi.models import ModelError
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.data import Turbine, rotor_torque
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import derated, optimal_torque_constant, rated_wind, trim


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


def test_power_is_the_product_of_both_set_points(turbine: Turbine) -> None:
    """80 % of the torque is 80 % of the power; with 95 % of the speed 76 %."""
    lower = derated(turbine, 0.8 * turbine.rated_torque)
    slower = 0.95 * turbine.rated_rotor_speed
    point = trim(lower, 16.0, speed_setpoint=slower)

    assert lower.rated_power == pytest.approx(0.8 * turbine.rated_power)
    power = turbine.generator_efficiency * turbine.gear_ratio * point.torque * point.rotor_speed
    assert power == pytest.approx(0.76 * turbine.rated_power)


def test_trim_and_schedule_balance_at_the_lower_torque(turbine: Turbine) -> None:
    """T_r = n_g T at every wind; the rotor is pitched further, and rated wind comes sooner."""
    lower = derated(turbine, 0.8 * turbine.rated_torque)
    schedule = effort_schedule(lower)
    for wind in (6.0, 10.0, 12.0, 20.0):
        point = trim(lower, wind)
        driving = float(rotor_torque(lower, point.rotor_speed, point.pitch, wind))
        assert driving == pytest.approx(turbine.gear_ratio * point.torque, rel=1e-9)
        if wind != 10.0:
            assert schedule.torque(wind, lower) == pytest.approx(point.torque, rel=2e-3)
    assert trim(lower, 14.0).pitch > trim(turbine, 14.0).pitch
    assert rated_wind(lower) < rated_wind(turbine) - 0.5
    assert trim(lower, 6.0) == trim(turbine, 6.0)


def test_what_is_not_changed(turbine: Turbine) -> None:
    """Rotor, tables, limits and wake are the turbine's; its own torque changes nothing at all."""
    lower = derated(turbine, 0.8 * turbine.rated_torque)

    assert derated(turbine, None) is turbine
    assert derated(turbine, turbine.rated_torque) is turbine
    assert lower.torque is turbine.torque and lower.frozen_wake is turbine.frozen_wake
    assert lower.maximum_torque == turbine.maximum_torque
    assert lower.figures["generator.rated_torque"].source == "torque set-point, 80 % of rated"
    assert turbine.figures["generator.rated_torque"].value != lower.rated_torque


def told(turbine: Turbine, torque: float, speed: float) -> tuple[float, float]:
    """Return the least torque [N m] and the largest speed [rad/s] that the refusal names."""
    with pytest.raises(ModelError, match="pitch cannot shed yet") as refused:
        derated(turbine, torque, speed_setpoint=speed)
    found = re.search(r"raise the torque to (\S+) N m .*to (\S+) rpm", str(refused.value))
    assert found is not None
    return float(found[1]), float(found[2]) * np.pi / 30


def test_both_remedies_that_are_told_work(turbine: Turbine) -> None:
    """70 % at full speed is too early; the named torque, or the named speed, is accepted."""
    speed, torque = turbine.rated_rotor_speed, 0.7 * turbine.rated_torque
    least, slower = told(turbine, torque, speed)

    assert rated_wind(derated(turbine, 1.0001 * least)) > 10.0
    lower = derated(turbine, torque, speed_setpoint=slower)
    assert trim(lower, 20.0, speed_setpoint=slower).torque == torque
    told(turbine, 0.998 * least, speed)
    told(turbine, torque, slower + 0.004)


def test_the_best_tip_speed_ratio_is_a_lower_bound(turbine: Turbine) -> None:
    """No accepted torque is below K (n_g omega)^2, 76.6 % at rated speed."""
    speed = turbine.rated_rotor_speed
    bound = optimal_torque_constant(turbine) * (turbine.gear_ratio * speed) ** 2
    least, _ = told(turbine, 0.999 * bound, speed)

    assert bound == pytest.approx(0.766 * turbine.rated_torque, rel=1e-3)
    assert bound <= least < 1.05 * bound


@pytest.mark.parametrize("torque", [0.0, -1.0, float("nan"), 5e4])
def test_torques_outside_the_range_are_misuse(turbine: Turbine, torque: float) -> None:
    """More than rated is no de-rating."""
    with pytest.raises(ModelError, match="torque set-point"):
        derated(turbine, torque)
