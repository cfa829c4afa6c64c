"""The reference's own controller, against its published structure and figures."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.models.laws.protocol import Law, Measurement
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import step_wind
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import trim
from tests.winds import constant_wind


def law() -> Law:
    return BaselineLaw(nrel5mw())


def test_gains_are_the_published_second_order_design() -> None:
    """K_P = 2 J W zeta w_n / (n_g S), K_I = J W w_n^2 / (n_g S) with w_n 0.6, zeta 0.7.

    Jonkman et al. (2009), NREL/TP-500-38060, sec. 7.3: S = 25.52 MW/rad at 0 deg.
    """
    turbine = nrel5mw()
    scale = turbine.inertia * turbine.rated_rotor_speed / (turbine.gear_ratio * 25.52e6)

    assert turbine.reference_controller.proportional_gain == pytest.approx(
        2 * 0.7 * 0.6 * scale, rel=1e-3
    )
    assert turbine.reference_controller.integral_gain == pytest.approx(0.6**2 * scale, rel=1e-3)


def test_torque_curve_through_its_regions() -> None:
    """0 below 670 rpm, K w^2 from 871 to 1136.5 rpm, rated at 1161.963 rpm, then P / w."""
    reference, rpm = BaselineLaw(nrel5mw()), np.pi / 30
    speeds = np.array([600, 670, 871, 1000, 1136.5, 1161.963, 1173.7, 1250]) * rpm
    torque = [reference.torque(float(speed), 0.0) for speed in speeds]

    assert torque[:2] == [0.0, 0.0]
    assert torque[2:5] == pytest.approx((2.332287 * speeds[2:5] ** 2).tolist(), rel=1e-9)
    # The published structure steps up by 1 % where constant power begins below rated speed.
    assert torque[5:] == pytest.approx((5.29661e6 / speeds[5:]).tolist(), rel=1e-6)
    assert torque[6] == pytest.approx(43093.55, rel=1e-6)


def test_torque_curve_has_no_other_step() -> None:
    """Up to region 3 the curve is continuous and never falls."""
    reference = BaselineLaw(nrel5mw())
    w_3 = nrel5mw().reference_controller.region_3_speed
    speeds = np.linspace(60.0, w_3, 7001, endpoint=False)
    torque = np.array([reference.torque(float(speed), 0.0) for speed in speeds])

    assert np.all(np.diff(torque) >= 0)
    assert np.diff(torque).max() < 45.0
    assert torque[-1] == pytest.approx(nrel5mw().rated_torque, rel=1e-3)


def test_pitch_above_one_degree_means_region_3() -> None:
    """The published rule: the torque of region 3 whatever the speed, at most 110 % of rated."""
    turbine = nrel5mw()
    reference = BaselineLaw(turbine)

    assert reference.torque(115.0, np.radians(0.9)) < 0.75 * turbine.rated_torque
    assert reference.torque(115.0, np.radians(1.1)) == pytest.approx(5.29661e6 / 115.0, rel=1e-6)
    assert reference.torque(90.0, np.radians(1.1)) == turbine.maximum_torque


def test_gain_halves_at_the_schedule_pitch() -> None:
    """1 / (1 + theta / 6.302336 deg): Jonkman et al. (2009), sec. 7.3."""
    turbine, rated = nrel5mw(), 122.9096
    fine, scheduled = (
        law().command(np.array([rated + 5.0, 0.0]), Measurement(1.27, pitch, 14.0)).pitch
        for pitch in (0.0, np.radians(6.302336))
    )

    assert fine == pytest.approx(5.0 * turbine.reference_controller.proportional_gain, rel=1e-4)
    assert scheduled == pytest.approx(fine / 2, rel=1e-6)


def test_integrator_stops_at_fine_pitch_and_leaves_it() -> None:
    """At 0 a speed below rated does not wind up; a speed above rated counts at once."""
    slow, fast = np.array([110.0, 0.0]), np.array([125.0, 0.0])
    measurement = Measurement(1.2, 0.0, 10.0)

    assert law().state_rate(slow, measurement)[1] == 0.0
    assert law().state_rate(fast, measurement)[1] == pytest.approx(125.0 - 122.9096, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("wind", range(12, 26))
def test_full_load_settles_at_trim_and_published_pitch(wind: int) -> None:
    """From a step of 0.4 m/s: rated speed, rated torque, pitch within 0.7 deg of the table of
    Jonkman et al. (2009), NREL/TP-500-38060."""
    turbine = nrel5mw()
    before = wind + (0.4 if wind < 25 else -0.4)
    history = simulate(
        validation_plant(turbine),
        law(),
        step_wind(before, float(wind), 100.0, begin=1.0),
        time_step=0.05,
    )
    point = trim(turbine, float(wind))
    published = turbine.frozen_wake.pitch[turbine.frozen_wake.wind.index(wind)]

    assert history.rotor_speed[-1] == pytest.approx(turbine.rated_rotor_speed, rel=1e-3)
    assert history.torque[-1] == pytest.approx(turbine.rated_torque, rel=1e-3)
    assert history.pitch[-1] == pytest.approx(point.pitch, abs=np.radians(0.1))
    assert abs(history.pitch[-1] - published) < np.radians(0.7)


def test_partial_load_settles_where_the_curve_meets_the_rotor() -> None:
    """At 8 m/s: T_r = n_g K (n_g w)^2 at fine pitch, near the best tip-speed ratio."""
    turbine = nrel5mw()
    plant = validation_plant(turbine)
    history = simulate(plant, law(), constant_wind(8.0, 200.0), time_step=0.05)
    speed = history.rotor_speed[-1]
    curve = turbine.gear_ratio**3 * turbine.reference_controller.optimal_torque_constant * speed**2

    assert history.rotor_torque[-1] == pytest.approx(curve, rel=1e-4)
    assert history.pitch[-1] == 0.0
    assert speed == pytest.approx(trim(turbine, 8.0).rotor_speed, rel=0.03)
