"""Metrics of records whose numbers can be computed by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import History, simulate
from takagi.models.simulation.scenario import damage_equivalent_load, measure, published_winds
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import step_wind
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import rated_wind
from tests.winds import constant_wind


def sawtooth_record() -> History:
    """Return 100 s at rated speed, pitch 0 to 2 deg and back, torque at 80 % in the second half."""
    turbine = nrel5mw()
    plain = simulate(
        validation_plant(turbine), BaselineLaw(turbine), constant_wind(9.0, 100.0), time_step=0.05
    )
    time = plain.time
    half = time < 50.0
    return replace(
        plain,
        rotor_speed=np.full_like(time, 1.02 * turbine.rated_rotor_speed),
        generator_speed=np.full_like(time, turbine.rated_rotor_speed),
        pitch=np.radians(2.0) * (1 - np.abs(time / 50.0 - 1)),
        torque=np.where(half, 1.0, 0.8) * turbine.rated_torque,
        tower_moment=3e6 * np.cos(np.pi * np.round(time)),
    )


def test_rainflow_of_the_standards_example() -> None:
    """ASTM E1049-85, fig. 6: range 3, 6 and 9 half; range 4 one and a half; range 8 one."""
    damage = 0.5 * 3**4 + 1.5 * 4**4 + 0.5 * 6**4 + 1.0 * 8**4 + 0.5 * 9**4
    series = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]

    assert damage_equivalent_load(series, 10.0) == pytest.approx((damage / 10.0) ** 0.25)
    assert damage_equivalent_load(series, 10.0, exponent=1.0, frequency=2.0) == pytest.approx(
        (1.5 + 6.0 + 3.0 + 8.0 + 4.5) / 20.0
    )


@pytest.mark.parametrize(
    ("torsion", "lag"), [(True, 0.05), (True, 0.0), (False, 0.05), (False, 0.0)]
)
def test_the_shaft_carries_generator_and_its_inertia(torsion: bool, lag: float) -> None:
    """S = n_g T + n_g^2 J_g omega_g', with the derivative of the recorded speed; T lags by hand."""
    turbine = nrel5mw()
    plant = validation_plant(turbine, torsion=torsion, torque_lag=lag)
    found = simulate(plant, BaselineLaw(turbine), step_wind(10.0, 13.0, 8.0, begin=1.0))
    time = found.time
    torque = found.torque.copy()
    if lag:
        # The command holds from a sample to the next, so the lag is exact from one to the next.
        torque[0] = found.torque[0]
        for k in range(1, len(time)):
            decay = np.exp(-(time[k] - time[k - 1]) / lag)
            torque[k] = found.torque[k - 1] + decay * (torque[k - 1] - found.torque[k - 1])
    speed = np.gradient(found.generator_speed, time, edge_order=2)
    inertia = turbine.gear_ratio**2 * turbine.generator_inertia
    wanted = turbine.gear_ratio * torque + inertia * speed
    # After the step of the wind, where a difference of samples is no derivative.
    moving = slice(60, -2)

    scale = turbine.gear_ratio * turbine.rated_torque
    assert np.ptp(found.shaft_torque) > 0.1 * scale
    assert found.shaft_torque[moving] / scale == pytest.approx(wanted[moving] / scale, abs=5e-3)


def test_peaks_of_a_record_made_by_hand() -> None:
    """A jump of 20 % of rated torque, half of it in a ramp of 0.8 s; power by its definition."""
    turbine, record = nrel5mw(), sawtooth_record()
    rated, time = turbine.rated_torque, record.time
    ramp = replace(record, torque=rated * (1 - 0.2 * np.clip((time - 50.0) / 0.8, 0.0, 1.0)))
    loud = replace(record, electrical_power=np.where(time == time[7], 5.5e6, 4e6))

    assert measure(record, turbine).torque_change == pytest.approx(0.2 * rated / 1e3)
    assert measure(ramp, turbine).torque_change == pytest.approx(0.1 * rated / 1e3)
    assert measure(loud, turbine).peak_power == pytest.approx(110.0)
    wave = replace(record, shaft_torque=2e6 * np.cos(np.pi * np.round(time)))
    # The tower's moment is the same wave, one and a half times as high.
    found = measure(wave, turbine)
    assert found.shaft_del == pytest.approx(found.tower_del / 1.5)


def test_the_blades_moment_at_rest_is_that_of_the_thrust() -> None:
    """A third of the thrust at two thirds of the radius; the mode swings at its own frequency."""
    turbine = nrel5mw()
    plants = [validation_plant(turbine), validation_plant(turbine, flap=False)]
    for plant in plants:
        rest = simulate(plant, BaselineLaw(turbine), constant_wind(9.0, 60.0))
        static = rest.thrust[-1] / 3 * 2 / 3 * turbine.rotor_radius
        assert rest.blade_moment[-1] == pytest.approx(static, rel=2e-3)
    found = measure(replace(rest, blade_moment=2e6 * np.cos(np.pi * np.round(rest.time))), turbine)
    assert found.blade_del == pytest.approx((60 / 2 / 60) ** 0.1 * 4.0, rel=0.02)


@given(
    st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=30),
    st.floats(0.1, 10.0),
    st.floats(-1e3, 1e3),
)
def test_equivalent_load_scales_and_ignores_the_mean(
    series: list[float], factor: float, offset: float
) -> None:
    """DEL(k x + c) = k DEL(x)."""
    load = np.round(series, 3)
    plain = damage_equivalent_load(load, 60.0)

    assert damage_equivalent_load(factor * load, 60.0) == pytest.approx(factor * plain, abs=1e-9)
    assert damage_equivalent_load(load + round(offset, 3), 60.0) == pytest.approx(
        plain, rel=1e-3, abs=1e-3
    )


def test_numbers_of_a_record_made_by_hand() -> None:
    """Energy 90 % of rated, travel 4 deg in 100 s, conflict from 50 s until pitch is 0.5 deg."""
    turbine = nrel5mw()
    found = measure(sawtooth_record(), turbine)

    assert found.duration == pytest.approx(100.0)
    assert found.mean_power == pytest.approx(0.9 * turbine.rated_power / 1e3, rel=1e-3)
    assert found.energy == pytest.approx(found.mean_power * 100.0 / 3600.0)
    assert found.overspeed == pytest.approx(2.0)
    assert found.speed_deviation == pytest.approx(0.0, abs=1e-9)
    assert found.pitch_travel == pytest.approx(4.0)
    assert found.pitch_rate == pytest.approx(0.04)
    assert found.both_active == pytest.approx(37.5, abs=0.1)
    drop = 0.2 * turbine.rated_torque
    assert found.torque_rate == pytest.approx(drop / 0.05 / np.sqrt(2000) / 1e3, rel=1e-6)
    # +-3 MN m at 0.5 Hz: half as many cycles of range 6 as the reference frequency has.
    assert found.tower_del == pytest.approx(6.0 * 0.5**0.25, rel=1e-2)


def test_misuse_is_told() -> None:
    with pytest.raises(ModelError, match="must be above 0"):
        damage_equivalent_load([0.0, 1.0], 0.0)
    with pytest.raises(ModelError, match="finite"):
        damage_equivalent_load([0.0, float("nan")], 10.0)


def test_paper_winds_lie_as_the_paper_says() -> None:
    """Schulte (2024): the highest mostly above rated with intervals below, the lowest below."""
    turbine = nrel5mw()
    above = [float(np.mean(w.speed > rated_wind(turbine))) for w in published_winds(turbine)]

    assert above[0] == 0.0
    assert 0.1 < above[1] < 0.9
    assert 0.6 < above[2] < 0.95


@pytest.mark.slow
def test_the_reference_overspeeds_on_the_step_up_and_not_on_the_step_down() -> None:
    turbine = nrel5mw()
    plant, law, rated = validation_plant(turbine), BaselineLaw(turbine), rated_wind(turbine)
    winds = [step_wind(rated - sign * 1.5, rated + sign * 1.5, 120) for sign in (1, -1)]
    up, down = (measure(simulate(plant, law, wind), turbine) for wind in winds)

    assert up.overspeed > 3.0
    assert down.overspeed < 1.0
