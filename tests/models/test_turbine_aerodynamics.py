"""Torque, power and thrust of the NREL 5-MW against published and separately computed figures."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.models import ModelError
from takagi.models.turbine.data import (
    rotor_thrust,
    rotor_torque,
    rotor_torque_gradient,
)
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import optimal_tip_speed_ratio, optimal_torque_constant


def static_sensitivity() -> list[tuple[float, float, float, float]]:
    """Return (wind m/s, published pitch deg, dP/dpitch MW/rad, thrust kN).

    Pitch: Jonkman et al. (2009), NREL/TP-500-38060.  The last two: bicubic interpolation of the
    ROSCO 2.10.6 NREL-5MW coefficient tables at that pitch, computed apart from this package.
    """
    return [
        (11.4, 0.00, -3.15, 736),
        (12, 3.83, -18.48, 591),
        (13, 6.60, -29.90, 506),
        (14, 8.70, -38.72, 451),
        (15, 10.45, -46.12, 414),
        (16, 12.06, -53.05, 383),
        (17, 13.54, -59.49, 358),
        (18, 14.92, -65.61, 338),
        (19, 16.23, -71.36, 320),
        (20, 17.47, -77.06, 306),
        (21, 18.70, -82.81, 292),
        (22, 19.94, -88.38, 274),
        (23, 21.18, -94.18, 256),
        (24, 22.35, -100.02, 242),
        (25, 23.47, -105.85, 229),
    ]


@pytest.mark.parametrize(("wind", "pitch", "sensitivity", "thrust"), static_sensitivity())
def test_sensitivity_and_thrust_columns(
    wind: float, pitch: float, sensitivity: float, thrust: float
) -> None:
    """dP/dpitch to 0.1 MW/rad and thrust to 1 kN at the published trim pitch."""
    turbine = nrel5mw()
    speed, angle = turbine.rated_rotor_speed, np.radians(pitch)
    by_pitch = rotor_torque_gradient(turbine, speed, angle, wind)[1]

    assert speed * by_pitch / 1e6 == pytest.approx(sensitivity, abs=0.11)
    assert rotor_thrust(turbine, speed, angle, wind) / 1e3 == pytest.approx(thrust, abs=1.1)


def test_gradient_against_differences() -> None:
    turbine = nrel5mw()
    generator = np.random.default_rng(2)
    wind = generator.uniform(6, 20, 100)
    speed = generator.uniform(3, 12, 100) * wind / turbine.rotor_radius
    pitch = generator.uniform(-0.05, 0.45, 100)
    point = np.array([speed, pitch, wind])
    for axis, exact in enumerate(rotor_torque_gradient(turbine, *point)):
        step = np.zeros((3, 1))
        step[axis] = 1e-6
        difference = rotor_torque(turbine, *(point + step)) - rotor_torque(turbine, *(point - step))

        assert exact == pytest.approx(difference / 2e-6, rel=1e-5, abs=10.0)


def test_peak_of_the_power_surface() -> None:
    """The spline of the ROSCO table peaks at c_P = 0.4661, lambda = 7.73, pitch 0.16 deg."""
    turbine = nrel5mw()
    ratios, pitch = np.linspace(6, 9, 301), np.radians(np.linspace(-2, 2, 401))
    c_p = turbine.power(ratios[:, None], pitch)
    i, j = np.unravel_index(np.argmax(c_p), c_p.shape)

    assert c_p[i, j] == pytest.approx(0.4661, abs=5e-5)
    assert ratios[i] == pytest.approx(7.73, abs=0.02)
    assert np.degrees(pitch[j]) == pytest.approx(0.16, abs=0.02)


def test_optimal_torque_constant_against_the_published_one() -> None:
    """rho pi R^5 c_P / (2 lambda^3 n_g^3) from (0.482, 7.55) is 2.332287 to 0.5 %; ours is lower.

    Source: OpenFAST 5-MW controller source (2.332287), Jonkman et al. (2009) (0.482 at 7.55).
    """
    turbine = nrel5mw()
    figures = turbine.figures
    published = (
        figures["reference.largest_power_coefficient"].value
        / figures["reference.optimal_tip_speed_ratio"].value ** 3
    )
    ratio = optimal_tip_speed_ratio(turbine)
    ours = float(turbine.torque(ratio, 0.0)) / ratio**2
    scale = turbine.torque_constant * turbine.rotor_radius**2 / turbine.gear_ratio**3

    assert scale * published == pytest.approx(
        turbine.reference_controller.optimal_torque_constant, rel=5e-3
    )
    assert optimal_torque_constant(turbine) == pytest.approx(scale * ours, rel=1e-12)
    assert 0.9 < optimal_torque_constant(turbine) / 2.332287 < 1.0


def test_outside_the_table_raises_unless_clipped() -> None:
    """No silent extrapolation; clip=True holds the coefficient at the table's edge."""
    turbine = nrel5mw()

    with pytest.raises(ModelError, match="tip-speed ratio"):
        rotor_torque(turbine, 2.0, 0.0, 5.0)
    with pytest.raises(ModelError, match="wind above 0"):
        rotor_torque(turbine, 1.0, 0.0, [8.0, 0.0])
    held = rotor_torque(turbine, 2.0, 0.0, 5.0, clip=True)
    assert held == pytest.approx(turbine.torque_constant * 25 * turbine.torque(14.5, 0.0))
    gradient = rotor_torque_gradient(turbine, 2.0, 0.0, 5.0, clip=True)
    edge = rotor_torque_gradient(turbine, 14.5 * 5 / 63, 0.0, 5.0)
    assert np.array(gradient) == pytest.approx(np.array(edge))
