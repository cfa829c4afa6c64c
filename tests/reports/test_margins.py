"""Margins of one loop, and the turbine's loops at a trim."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.models import ModelError
from takagi.models.turbine.aerodynamics import rotor_thrust, rotor_torque
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import TrimPoint, trim
from takagi.reports.margins.margins import disk_margin, disk_of, loop_margins
from takagi.reports.margins.response import loop_response
from takagi.reports.margins.turbine_loops import (
    FirstOrderDrive,
    LocalGains,
    break_loops,
    linear_plant,
    loops_at_trim,
    plant_at_trim,
)


def ziegler_nichols_loop() -> Any:
    """Process and PI controller of Skogestad & Postlethwaite (2005), section 2.4."""
    s = control.tf("s")
    return 3 * (1 - 2 * s) / ((5 * s + 1) * (10 * s + 1)) * (2.5 / 2.2) * (1 + 1 / (12.7 * s))


def is_stable(loop: Any) -> bool:
    """Whether the loop is stable when closed, from the poles alone."""
    return bool(np.all(control.feedback(loop, 1).poles().real < 0))


def test_textbook_loop_has_the_published_margins_and_peaks() -> None:
    """Skogestad & Postlethwaite (2005), 2.4: GM 1.63, PM 19.4 deg, M_s 3.92, M_t 3.35, w_B 0.14."""
    found = loop_margins(ziegler_nichols_loop())

    assert found.stable
    assert found.gain_increase == pytest.approx(1.63, abs=0.006)
    assert np.degrees(found.phase) == pytest.approx(19.4, abs=0.06)
    # The book's controller gain is printed to three figures; the peaks move by 0.02 within that.
    assert found.sensitivity_peak == pytest.approx(3.92, abs=0.02)
    assert found.complementary_peak == pytest.approx(3.35, abs=0.02)
    assert found.bandwidth == pytest.approx(0.14, abs=0.005)
    assert found.gain_decrease == 0


@settings(derandomize=True, max_examples=20, deadline=None)
@given(gain=st.floats(0.01, 100.0))
def test_integrator_has_ninety_degrees_and_a_quarter_turn_of_delay(gain: float) -> None:
    """L = k/s: crossover k, phase margin pi/2, delay margin pi/(2k), M_s = 1, no gain margin."""
    found = loop_margins(control.tf(gain, [1, 0]))

    assert found.crossover == pytest.approx(gain, rel=1e-9)
    assert found.phase == pytest.approx(np.pi / 2, rel=1e-9)
    assert found.delay == pytest.approx(np.pi / 2 / gain, rel=1e-9)
    assert found.sensitivity_peak == pytest.approx(1.0, abs=1e-3)
    assert found.bandwidth == pytest.approx(gain, rel=1e-9)
    assert (found.gain_decrease, found.gain_increase) == (0.0, np.inf)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(
    gain=st.floats(0.1, 20.0),
    lag=st.floats(0.05, 5.0),
    frequency=st.floats(0.5, 10.0),
    damping=st.floats(0.02, 1.5),
)
def test_margins_agree_with_the_polynomial_method(
    gain: float, lag: float, frequency: float, damping: float
) -> None:
    """python-control finds the same margins from polynomial roots, where the loop is stable."""
    mode = control.tf(frequency**2, [1, 2 * damping * frequency, frequency**2])
    loop = control.tf(gain, [lag, 1]) * mode
    found = loop_margins(loop)

    assert found.stable == is_stable(loop)
    if not found.stable:
        assert (found.gain_increase, found.phase, found.delay, found.disk.alpha) == (1, 0, 0, 0)
        assert found.sensitivity_peak == np.inf
        return
    gains, phases, _, _, _, _ = control.stability_margins(loop, returnall=True)
    upward = [factor for factor in gains if factor > 1]
    assert found.gain_increase == pytest.approx(min(upward, default=np.inf), rel=1e-6)
    if len(phases):
        assert np.degrees(found.phase) == pytest.approx(np.min(np.abs(phases)), rel=1e-5, abs=1e-5)


def test_unstable_plant_has_a_gain_it_may_not_fall_below() -> None:
    """L = 2/(s - 1): 1 + g L = 0 at s = 0 for g = 1/2; |L| = 1 at sqrt 3, 60 degrees away."""
    found = loop_margins(control.tf(2, [1, -1]))

    assert found.stable
    assert found.gain_decrease == pytest.approx(0.5, rel=1e-12)
    assert found.gain_decrease_frequency == 0
    assert found.phase == pytest.approx(np.pi / 3, rel=1e-9)


@pytest.mark.parametrize(
    ("loop", "words"),
    [
        (control.ss(-np.eye(2), np.eye(2), np.eye(2), np.zeros((2, 2))), "2 x 2"),
        (control.ss(-1.0, np.ones((1, 2)), 1.0, np.zeros((1, 2))), "as many inputs as outputs"),
        (control.ss(0.5, 1.0, 1.0, 0.0, 0.02), "discrete"),
    ],
)
def test_misuse_names_what_was_given(loop: Any, words: str) -> None:
    """A loop of the wrong kind is refused with the reason."""
    with pytest.raises(ModelError, match=words):
        loop_margins(loop)


def published_pitch_loop() -> Any:
    """Jonkman et al. (2009), 7.4: -25.52 MW/rad at 0 deg, KP 0.01882681 s, KI 0.008068634."""
    sensitivity = -25.52e6 / (1.267109 * 43784725)
    plant = linear_plant(
        speed=0.0, pitch=sensitivity, wind=0.0, torque=0.0, drive=FirstOrderDrive(1e-4)
    )
    gains = LocalGains(pitch_by_speed=97 * 0.01882681, pitch_by_integral=-97 * 0.008068634)
    return break_loops(plant, gains)


def test_published_pitch_controller_has_its_published_frequency_and_damping() -> None:
    """The reference's gains were chosen for 0.6 rad/s and damping 0.7 (Jonkman et al. 2009)."""
    slow = published_pitch_loop().poles[:2]

    assert np.abs(slow) == pytest.approx([0.6, 0.6], rel=2e-3)
    assert -slow.real / np.abs(slow) == pytest.approx([0.7, 0.7], rel=5e-3)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    """The reference turbine."""
    return nrel5mw()


def both_acting() -> LocalGains:
    """Gains with which torque and pitch act at once, the hardest case for breaking one loop."""
    return LocalGains(
        torque_by_speed=8e4,
        torque_by_integral=-1e4,
        pitch_by_speed=0.6,
        pitch_by_pitch=-0.1,
        pitch_by_integral=-0.1,
    )


@pytest.mark.parametrize("wind", [8.0, 12.0, 18.0])
def test_each_broken_loop_closes_to_the_same_poles(turbine: Turbine, wind: float) -> None:
    """Closing the torque loop, the pitch loop or both gives one and the same closed loop."""
    loops = loops_at_trim(turbine, trim(turbine, wind), both_acting())

    for broken in (loops.torque, loops.pitch):
        poles = np.sort_complex(control.feedback(broken, 1).poles())
        # The two Pade delays give nearly double poles, whose position is known to 1e-5 only.
        assert poles == pytest.approx(np.sort_complex(loops.poles), rel=1e-4, abs=1e-6)


def test_both_loops_at_once_bear_no_more_than_each_alone(turbine: Turbine) -> None:
    """The disk margin of the 2 x 2 loop is at most those of the two broken scalar loops."""
    loops = loops_at_trim(turbine, trim(turbine, 12.0), both_acting())
    both = disk_of(loop_response(loops.both))

    single = (disk_margin(loops.torque).alpha, disk_margin(loops.pitch).alpha)
    assert 0 < both.alpha <= min(single) * (1 + 1e-9)


def nonlinear_rate(turbine: Turbine, x: NDArray[np.float64], u: NDArray[np.float64]) -> Any:
    """State rate of omega, beta, beta', tower, tower'; written down apart from the linear plant."""
    omega, beta, rate, place, velocity = x
    torque, reference, wind = u
    seen = wind - velocity
    w, zeta = turbine.pitch_drive_frequency, turbine.pitch_drive_damping
    thrust = float(rotor_thrust(turbine, omega, beta, seen))
    force = thrust - turbine.tower_damping * velocity - turbine.tower_stiffness * place
    shaft = float(rotor_torque(turbine, omega, beta, seen)) - turbine.gear_ratio * torque
    pitch = w**2 * (reference - beta) - 2 * zeta * w * rate
    return np.array([shaft / turbine.inertia, rate, pitch, velocity, force / turbine.tower_mass])


def numeric_jacobian(turbine: Turbine, point: TrimPoint) -> tuple[Any, Any]:
    """Central differences of the nonlinear rate at a trim."""
    x = np.array([point.rotor_speed, point.pitch, 0.0, 0.0, 0.0])
    u = np.array([point.torque, point.pitch, point.wind])
    steps = np.array([1e-5, 1e-5, 1e-5, 1e-4, 1e-5, 1.0, 1e-5, 1e-5])
    columns = []
    for k, step in enumerate(steps):
        shift = np.zeros(8)
        shift[k] = step
        ahead = nonlinear_rate(turbine, x + shift[:5], u + shift[5:])
        behind = nonlinear_rate(turbine, x - shift[:5], u - shift[5:])
        columns.append((ahead - behind) / (2 * step))
    jacobian = np.array(columns).T
    return jacobian[:, :5], jacobian[:, 5:]


@pytest.mark.parametrize("wind", [7.0, 14.0, 22.0])
def test_validation_plant_is_the_jacobian_of_the_nonlinear_one(
    turbine: Turbine, wind: float
) -> None:
    """Its response is that of the differenced nonlinear plant, times filter and exact delay."""
    point = trim(turbine, wind)
    plant = plant_at_trim(turbine, point)
    A, B = numeric_jacobian(turbine, point)
    for omega in (0.1, 1.0, 2.0, 5.0):
        s = 1j * omega
        expected = np.linalg.solve(s * np.eye(5) - A, B)[:2]
        expected[0] *= turbine.speed_filter / (s + turbine.speed_filter)
        expected[:, :2] *= np.exp(-0.03 * s)
        found = plant(s)
        scale = np.max(np.abs(expected), axis=0)
        assert np.all(np.abs(found - expected) <= 1e-4 * scale)


def test_design_and_validation_plant_agree_when_slow(turbine: Turbine) -> None:
    """Lags do not matter at DC; the tower leans but does not change the steady speed."""
    point = trim(turbine, 16.0)
    design, rich = (plant_at_trim(turbine, point, kind=kind) for kind in ("design", "validation"))

    assert design.dcgain() == pytest.approx(rich.dcgain(), rel=1e-9)
