"""Disk margins: published examples, mu from both sides, and what the disk promises."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.reports.margins.margins import DiskMargin, disk_of, loop_margins, scaled_bound
from tests.reports.control_loops import response_of


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


@settings(derandomize=True, max_examples=25, deadline=None)
@given(gain=st.floats(0.1, 3.5), size=st.floats(0.0, 0.999), angle=st.floats(0, 2 * np.pi))
def test_every_factor_inside_the_disk_leaves_the_loop_stable(
    gain: float, size: float, angle: float
) -> None:
    """A constant complex factor inside the disk keeps all roots of den + f num on the left."""
    numerator, denominator = 25 * gain, np.array([1.0, 10.0, 10.0, 10.0])
    found = disk_of(response_of(control.tf(numerator, denominator)))
    d = size * np.exp(1j * angle)
    factor = (2 + found.alpha * d) / (2 - found.alpha * d)
    polynomial = denominator + np.array([0, 0, 0, factor * numerator])

    assert np.all(np.roots(polynomial).real < 1e-9)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(gain=st.floats(0.1, 3.4), lag=st.floats(0.01, 1.0))
def test_disk_never_promises_more_than_the_classical_margins(gain: float, lag: float) -> None:
    """Gain and phase guaranteed together are at most what each has alone."""
    found = loop_margins(
        response_of(control.tf(25 * gain, [1, 10, 10, 10]) * control.tf(1, [lag, 1]))
    )
    if not found.stable:
        return

    assert found.disk.gain_increase <= found.gain_increase * (1 + 1e-9)
    assert found.disk.gain_decrease >= found.gain_decrease - 1e-9
    assert found.disk.phase <= found.phase + 1e-9
    assert found.disk.alpha >= 2 / (found.sensitivity_peak + found.complementary_peak) - 1e-9


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


@settings(derandomize=True, max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_two_by_two_bound_is_mu_itself(seed: int) -> None:
    """Upper bound by scaling and lower bound by rotation meet (Packard & Doyle 1993)."""
    matrices = random_matrices(seed)
    below = [lower_bound(matrix) for matrix in matrices]

    assert scaled_bound(matrices) == pytest.approx(below, rel=1e-5)


def test_scaling_a_channel_changes_nothing() -> None:
    """A margin must not depend on the units of the actuators."""
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
