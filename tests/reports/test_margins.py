"""Margins of one loop, and the turbine's loops at a trim."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.reports.margins.margins import DiskMargin, disk_of, loop_margins, scaled_bound
from takagi.reports.margins.response import LoopResponse, broken_loops
from takagi.reports.margins.running_loop import LoopEquilibrium, RunningLoop
from tests.reports.margin_rows import response_of


def ziegler_nichols_loop() -> Any:
    """Process and PI controller of Skogestad & Postlethwaite (2005), section 2.4."""
    s = control.tf("s")
    return 3 * (1 - 2 * s) / ((5 * s + 1) * (10 * s + 1)) * (2.5 / 2.2) * (1 + 1 / (12.7 * s))


def is_stable(loop: Any) -> bool:
    return bool(np.all(control.feedback(loop, 1).poles().real < 0))


def test_textbook_loop_has_the_published_margins_and_peaks() -> None:
    """Skogestad & Postlethwaite (2005), 2.4: GM 1.63, PM 19.4 deg, M_s 3.92."""
    found = loop_margins(response_of(ziegler_nichols_loop()))

    assert found.stable
    assert found.gain_increase == pytest.approx(1.63, abs=0.006)
    assert np.degrees(found.phase) == pytest.approx(19.4, abs=0.06)
    # The book's controller gain is printed to three figures; the peaks move by 0.02 within that.
    assert found.sensitivity_peak == pytest.approx(3.92, abs=0.02)
    assert found.gain_decrease == 0


@given(gain=st.floats(0.01, 100.0))
def test_integrator_has_ninety_degrees_and_a_quarter_turn_of_delay(gain: float) -> None:
    """L = k/s: crossover k, phase margin pi/2, delay margin pi/(2k), M_s = 1, no gain margin."""
    found = loop_margins(response_of(control.tf(gain, [1, 0])))

    assert found.crossover == pytest.approx(gain, rel=1e-9)
    assert found.phase == pytest.approx(np.pi / 2, rel=1e-9)
    assert found.delay == pytest.approx(np.pi / 2 / gain, rel=1e-9)
    assert found.sensitivity_peak == pytest.approx(1.0, abs=1e-3)
    assert (found.gain_decrease, found.gain_increase) == (0.0, np.inf)


@given(
    gain=st.floats(0.1, 20.0),
    lag=st.floats(0.05, 5.0),
    frequency=st.floats(0.5, 10.0),
    damping=st.floats(0.02, 1.5),
)
def test_margins_agree_with_the_polynomial_method(
    gain: float, lag: float, frequency: float, damping: float
) -> None:
    mode = control.tf(frequency**2, [1, 2 * damping * frequency, frequency**2])
    loop = control.tf(gain, [lag, 1]) * mode
    found = loop_margins(response_of(loop))

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
    found = loop_margins(response_of(control.tf(2, [1, -1])))

    assert found.stable
    assert found.gain_decrease == pytest.approx(0.5, rel=1e-12)
    assert found.phase == pytest.approx(np.pi / 3, rel=1e-9)


def spinning_satellite(controller: Any) -> Any:
    """The two-channel satellite with a = 10, at its output (Zhou, Doyle & Glover 1996, 9.6)."""
    plant = control.ss([[0, 10], [-10, 0]], np.eye(2), [[1, 10], [-10, 1]], 0)
    return plant * control.ss([], [], [], controller)


def test_published_example() -> None:
    """Seiler, Packard & Gahinet (2020): alpha 0.46 at 1.94 rad/s, 4.05 dB (1.59), 25.8 degrees."""
    found = disk_of(response_of(control.tf(25, [1, 10, 10, 10])))

    assert found.alpha == pytest.approx(0.46, abs=0.005)
    assert found.frequency == pytest.approx(1.95, abs=0.02)
    assert 20 * np.log10(found.gain_increase) == pytest.approx(4.05, abs=0.005)
    assert found.gain_decrease == pytest.approx(1 / 1.59, abs=0.005)
    assert np.degrees(found.phase) == pytest.approx(25.8, abs=0.05)


def test_published_two_loop_example() -> None:
    """The satellite under [[1, -2], [0, 1]] has alpha 0.375 (python-control's documentation)."""
    found = disk_of(response_of(spinning_satellite([[1, -2], [0, 1]])))

    assert found.alpha == pytest.approx(0.3754, abs=1e-3)
    assert 20 * np.log10(found.gain_increase) == pytest.approx(3.3, abs=0.01)
    assert np.degrees(found.phase) == pytest.approx(21.26, abs=0.06)


def test_loops_that_are_perfect_one_at_a_time_are_fragile_together() -> None:
    """Satellite under unit feedback: each loop is 1/s (alpha 2), both at once about 1/a."""
    found = disk_of(response_of(spinning_satellite(np.eye(2))))

    assert disk_of(response_of(control.tf(1, [1, 0]))).alpha == pytest.approx(2.0, abs=1e-4)
    assert found.alpha == pytest.approx(0.1, abs=1e-3)


def test_worst_factor_in_the_disk_is_on_the_brink() -> None:
    """f = (2 + alpha d)/(2 - alpha d) with |d| = 1 puts 1 + f L at 0 at the stated frequency."""
    loop = control.tf(25, [1, 10, 10, 10])
    found = disk_of(response_of(loop))
    value = complex(loop(1j * found.frequency))
    factor = -1 / value
    d = 2 * (factor - 1) / (found.alpha * (factor + 1))

    assert abs(d) == pytest.approx(1.0, rel=1e-9)


def random_matrices(seed: int) -> NDArray[np.complex128]:
    """Ten matrices whose rows and columns differ in size by some thousands."""
    generator = np.random.default_rng(seed)
    values = generator.normal(size=(10, 2, 2)) + 1j * generator.normal(size=(10, 2, 2))
    scale = 10.0 ** generator.uniform(-2, 2, size=(10, 2))
    return np.asarray(scale[:, :, None] * values / scale[:, None, :], dtype=np.complex128)


def lower_bound(matrix: NDArray[np.complex128]) -> float:
    """max over diagonal unitary U of the spectral radius of U M, on a grid of phases."""
    phases = np.exp(1j * np.linspace(0, 2 * np.pi, 2001))
    turned = np.broadcast_to(matrix, (len(phases), 2, 2)).copy()
    turned[:, 1, :] *= phases[:, None]
    return float(np.abs(np.linalg.eigvals(turned)).max())


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000))
def test_two_by_two_bound_is_mu_itself(seed: int) -> None:
    """Upper bound by scaling and lower bound by rotation meet (Packard & Doyle 1993)."""
    matrices = random_matrices(seed)
    below = [lower_bound(matrix) for matrix in matrices]

    assert scaled_bound(matrices) == pytest.approx(below, rel=1e-5)


def test_scaling_a_channel_changes_nothing() -> None:
    loop = spinning_satellite([[1, -2], [0, 1]])
    units = control.ss([], [], [], np.diag([1e4, 1e-2]))
    back = control.ss([], [], [], np.diag([1e-4, 1e2]))

    there = disk_of(response_of(units * loop * back)).alpha
    assert there == pytest.approx(disk_of(response_of(loop)).alpha, rel=1e-9)


def test_disk_of_size_two_and_more_has_no_upper_gain() -> None:
    """From alpha = 2 on the disk holds all gains above; below 0 no gain is promised."""
    assert DiskMargin(2.0, 1.0).gain_increase == np.inf
    assert DiskMargin(2.0, 1.0).gain_decrease == 0
    assert DiskMargin(3.0, 1.0).gain_decrease == 0
    assert np.degrees(DiskMargin(2.0, 1.0).phase) == pytest.approx(90)


def scalar_loop(A: Any, B: Any, C: Any, period: float = 0.1) -> LoopResponse:
    size = len(A)
    entry, answer = np.zeros((size, 2)), np.zeros((2, size))
    entry[:, 0], answer[0] = B, C
    rest = LoopEquilibrium(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(2))
    ones = np.ones(size)
    return broken_loops(
        RunningLoop(0.0, period, np.array(A, dtype=float), entry, answer, ones, (), rest)
    ).torque


# --- loops whose margins are known ---------------------------------------------------------------


def test_sampled_integrator_has_its_textbook_margins() -> None:
    """L = k T / (z - 1), Franklin, Powell & Workman: unstable from k T = 2, at pi / T."""
    gain, period = 4.0, 0.1
    found = loop_margins(scalar_loop([[1.0]], [gain * period], [1.0], period))
    assert found.gain_increase == pytest.approx(2 / (gain * period))
    assert found.gain_increase_frequency == pytest.approx(np.pi / period)
    # |L| = 1 at 2 sin(w T / 2) = k T, where the phase is -(pi + w T) / 2.
    crossing = 2 / period * np.arcsin(gain * period / 2)
    assert found.crossover == pytest.approx(crossing)
    assert found.phase == pytest.approx((np.pi - crossing * period) / 2)
    assert found.delay == pytest.approx(found.phase / crossing)
    # S - 1/2 = (z - 1 - kT) / (z - 1 + kT) / 2 is largest at z = -1.
    assert found.disk.alpha == pytest.approx(2 * (2 - gain * period) / (2 + gain * period))


def test_a_delay_of_whole_samples_is_exact() -> None:
    gain, period = 1.5, 0.1
    margin = loop_margins(scalar_loop([[1.0]], [gain * period], [1.0], period)).delay

    def grows(samples: int) -> bool:
        late = np.diag(np.ones(samples), 1)
        late[0, 0], late[-1, 0] = 1.0, -gain * period
        late[:-1, 0] = 0.0
        A = np.zeros((samples + 1, samples + 1))
        A[0, 0] = 1.0
        if samples:
            A[0, 1] = gain * period
            A[np.arange(1, samples), np.arange(2, samples + 1)] = 1.0
            A[samples, 0] = -1.0
        else:
            A[0, 0] -= gain * period
        return float(np.abs(np.linalg.eigvals(A)).max()) > 1

    assert not grows(int(margin / period))
    assert grows(int(margin / period) + 1)


def test_fast_sampling_gives_the_published_disk_margin() -> None:
    """L = 25 / (s^3 + 10 s^2 + 10 s + 10): alpha = 0.46, Seiler, Packard & Gahinet (2020)."""
    import control

    system = control.ss(control.tf(25, [1, 10, 10, 10]))
    sampled = control.c2d(system, 1e-4)
    found = disk_of(scalar_loop(sampled.A, sampled.B[:, 0], sampled.C[0], 1e-4))
    assert found.alpha == pytest.approx(disk_of(response_of(system)).alpha, rel=1e-3)
    assert found.alpha == pytest.approx(0.46, abs=0.005)
