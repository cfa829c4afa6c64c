"""Margins of sampled loops that are known from textbooks and publications."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.reports.margins.margins import disk_of, loop_margins
from takagi.reports.margins.response import LoopResponse, broken_loops
from takagi.reports.margins.running_loop import LoopEquilibrium, RunningLoop
from tests.reports.control_loops import response_of


def scalar_loop(A: Any, B: Any, C: Any, period: float = 0.1) -> LoopResponse:
    """A loop at the torque alone; the pitch does nothing."""
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
    """The loop stays stable with as many late samples as its delay margin says, and no more."""
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
