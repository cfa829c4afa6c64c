"""Steady operation of the NREL 5-MW over wind, against its figure sheet."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.data import Turbine, rotor_torque, rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine, nrel5mw
from takagi.models.turbine.trim import (
    TABLE_SHARE,
    derated,
    optimal_tip_speed_ratio,
    optimal_torque_constant,
    rated_wind,
    reference_speed,
    trim,
)


@pytest.mark.parametrize("wind", range(12, 26))
def test_pitch_is_near_the_published_column(wind: int) -> None:
    """Within 0.7 deg of Jonkman et al. (2009), NREL/TP-500-38060, for 12 to 25 m/s."""
    turbine = nrel5mw()
    published = turbine.frozen_wake.pitch[turbine.frozen_wake.wind.index(wind)]

    assert np.degrees(abs(trim(turbine, wind).pitch - published)) < 0.7


def test_rated_wind() -> None:
    """11.45 m/s on this table; Jonkman et al. (2009) have 11.4 with another one."""
    assert rated_wind(nrel5mw()) == pytest.approx(11.45, abs=0.005)
    assert rated_wind(nrel5mw()) == pytest.approx(11.4, rel=0.01)


@pytest.mark.parametrize(
    ("wind", "a", "b", "d"),
    [
        (8.0, -0.044, 0.0, 0.016),
        (11.4, -0.061, -0.057, 0.023),
        (14.0, -0.10, -0.69, 0.023),
        (25.0, -0.53, -1.89, 0.034),
    ],
)
def test_partial_derivatives_at_trim(wind: float, a: float, b: float, d: float) -> None:
    """Computed apart from this package from the same coefficient table; 8 m/s has b near 0."""
    turbine = nrel5mw()
    point = trim(turbine, wind)
    found = np.array(rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, wind))

    assert found / turbine.inertia == pytest.approx([a, b, d], rel=0.05, abs=0.003)


loaded = cache(load_turbine)


@given(
    name=st.sampled_from(["nrel5mw", "iea15mw"]),
    wind=st.floats(3.0, 25.0),
    share=st.floats(0.81, 0.99),
)
def test_trim_balances_within_limits(name: str, wind: float, share: float) -> None:
    """T_r = n_g T_g, torque and pitch within limits, lambda inside its share of the table."""
    turbine = loaded(name)
    for wanted in (None, share * turbine.rated_rotor_speed):
        point = trim(turbine, wind, speed_setpoint=wanted)
        torque = float(rotor_torque(turbine, point.rotor_speed, point.pitch, wind))
        ratio = point.rotor_speed * turbine.rotor_radius / wind

        assert torque == pytest.approx(turbine.gear_ratio * point.torque, rel=1e-9)
        assert 0 < point.torque <= turbine.rated_torque * (1 + 1e-12)
        assert turbine.pitch_min <= point.pitch <= turbine.pitch_max
        assert 2 < ratio <= TABLE_SHARE * 14.5 + 1e-9


def test_regions_follow_each_other() -> None:
    """1.5, 2, 2.5, 3 in this order; each boundary where its formula says."""
    turbine = nrel5mw()
    winds = np.linspace(3, 25, 221)
    regions = [trim(turbine, float(wind)).region for wind in winds]
    ratio = optimal_tip_speed_ratio(turbine)
    start_2 = turbine.minimum_rotor_speed * turbine.rotor_radius / ratio
    start_25 = turbine.rated_rotor_speed * turbine.rotor_radius / ratio

    assert regions == sorted(regions, key=["1.5", "2", "2.5", "3"].index)
    for wind, before, after in (
        (start_2, "1.5", "2"),
        (start_25, "2", "2.5"),
        (rated_wind(turbine), "2.5", "3"),
    ):
        assert trim(turbine, wind - 1e-6).region == before
        assert trim(turbine, wind + 1e-6).region == after


@pytest.mark.parametrize(
    ("name", "largest"),
    [("nrel5mw", (0.005, 0.008, 300.0)), ("iea15mw", (0.003, 0.012, 1.2e5))],
)
def test_trim_is_continuous(name: str, largest: tuple[float, float, float]) -> None:
    points = [trim(loaded(name), float(wind)) for wind in np.linspace(3, 25, 1101)]

    assert list(dict.fromkeys(point.region for point in points)) == ["1.5", "2", "2.5", "3"]
    for column, most in zip(("rotor_speed", "pitch", "torque"), largest, strict=True):
        assert np.abs(np.diff([getattr(point, column) for point in points])).max() < most


def test_minimum_speed_is_given_up_at_low_wind() -> None:
    """At 3 m/s the speed is below 670/97 rpm, from 3.5 m/s it is 670/97 rpm."""
    turbine = nrel5mw()

    assert reference_speed(turbine, 3.0) == pytest.approx(TABLE_SHARE * 14.5 * 3.0 / 63.0)
    assert reference_speed(turbine, 3.5) == pytest.approx(670 / 97 * np.pi / 30)


def test_infeasible_requests_name_wind_and_cure() -> None:
    turbine = nrel5mw()

    with pytest.raises(ModelError, match="wind 26 m/s .* cut-out 25"):
        trim(turbine, 26.0)
    with pytest.raises(ModelError, match="wind nan"):
        reference_speed(turbine, float("nan"))
    with pytest.raises(ModelError, match="at or below the rated"):
        trim(turbine, 10.0, speed_setpoint=1.3)
    with pytest.raises(ModelError, match="above the minimum"):
        rated_wind(turbine, speed_setpoint=0.5)
    with pytest.raises(ModelError, match="wind 11.2016 m/s .* stall side .* raise the speed"):
        trim(turbine, 12.0, speed_setpoint=0.9)


@pytest.mark.parametrize("torque", [4000.0, 8000.0])
def test_rated_torque_that_is_reached_at_half_speed_is_named(torque: float) -> None:
    """Pitch would have to hold it at rated speed, whose tip-speed ratio is beyond the table."""
    small = replace(nrel5mw(), rated_torque=torque)

    with pytest.raises(ModelError) as caught:
        trim(small, 8.0)

    message = str(caught.value)
    assert f"rated torque {torque:g} N m is reached at" in message
    assert "before rated speed, 1.267 rad/s" in message
    assert "raise rated torque or lower rated speed" in message


def test_a_rotor_that_is_stalled_at_rated_wind_is_told_its_least_pitch() -> None:
    """The angle was tried: with it pitch sheds torque there, and with the next smaller one not."""
    stalled = replace(load_turbine("iea15mw"), pitch_min=0.0)

    with pytest.raises(ModelError) as caught:
        rated_wind(stalled)

    message = str(caught.value)
    found = re.search(r"give ([0-9.]+) deg or more as pitch.minimum", message)
    assert found is not None and "set-point" not in message
    assert rated_wind(replace(stalled, pitch_min=np.radians(float(found[1])))) > 10
    with pytest.raises(ModelError, match="pitch.minimum"):
        rated_wind(replace(stalled, pitch_min=np.radians(float(found[1]) - 0.25)))


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
    lower = derated(turbine, 0.8 * turbine.rated_torque)

    assert derated(turbine, None) is turbine
    assert derated(turbine, turbine.rated_torque) is turbine
    assert lower.torque is turbine.torque and lower.frozen_wake is turbine.frozen_wake
    assert lower.maximum_torque == turbine.maximum_torque
    assert lower.figures["generator.rated_torque"].source == "torque set-point, 80 % of rated"
    assert turbine.figures["generator.rated_torque"].value != lower.rated_torque


def told(turbine: Turbine, torque: float, speed: float) -> tuple[float, float]:
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
    with pytest.raises(ModelError, match="torque set-point"):
        derated(turbine, torque)
