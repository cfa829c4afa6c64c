"""The peak of one vertex by its Lyapunov equation: closed forms, the LMIs, and its room."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import peak_gain
from takagi.lmi.analysis.disturbance import OneVertex, disturbance_channel, peak_bound

Floats = NDArray[np.float64]


def vertex(step: float | None, through: float = 0.0) -> tuple[Floats, Floats, Floats, Floats]:
    """Return three states that ring, two disturbances, two outputs."""
    A = np.array([[-0.4, 1.0, 0.0], [-1.0, -0.4, 0.5], [0.0, 0.2, -1.5]])
    A = A if step is None else np.eye(3) + step * A
    B = np.array([[0.0, 0.3], [1.0, 0.0], [0.2, -0.4]])
    C = np.array([[1.0, 0.0, 0.3], [0.0, 0.5, -1.0]])
    return A, B, C, through * np.array([[1.0, 0.5], [0.0, 0.3]])


@pytest.mark.parametrize("through", [0.0, 0.7])
@pytest.mark.parametrize("a", [0.3, 2.0])
def test_one_state_has_its_exact_peak(a: float, through: float) -> None:
    """x' = -a x + 3 w, y = 2 x + d w: |y| <= 6 / a + d, at half the rate of the pole."""
    one = OneVertex.of(
        np.array([[-a]]), np.array([[3.0]]), np.array([[2.0]]), np.array([[through]]), step=None
    )
    rate = one.best_rate()

    assert rate is not None and rate == pytest.approx(a / 2, rel=1e-3)
    assert one.gain_at(one.sigma(rate)) == pytest.approx(6 / a + through, rel=1e-6)


@pytest.mark.parametrize("a", [0.0, 0.5, -0.9])
def test_one_sampled_state_has_its_exact_peak(a: float) -> None:
    """x+ = a x + w, y = x: |y| <= 1 / (1 - |a|), at the decay |a| a sample."""
    one = OneVertex.of(np.array([[a]]), np.eye(1), np.eye(1), np.zeros((1, 1)), step=0.1)
    rate = one.best_rate()

    assert rate is not None
    assert one.gain_at(one.sigma(rate)) == pytest.approx(1 / (1 - abs(a)), rel=1e-4)


@pytest.mark.parametrize("step", [None, 0.1])
@pytest.mark.parametrize("through", [0.0, 0.7])
def test_it_is_what_the_program_finds(step: float | None, through: float) -> None:
    """At a rate, and over all rates, where the LMIs are about a norm that is no less."""
    path = vertex(step, through)
    one = OneVertex.of(*path, step=step)
    answer = peak_gain(*path, sample_time=step, decay_rate=0.2)
    best, rate = peak_gain(*path, sample_time=step), one.best_rate()

    assert answer.gain is not None and best.gain is not None and rate is not None
    assert one.gain_at(one.sigma(0.2)) == pytest.approx(answer.gain, rel=1e-5)
    assert best.gain * (1 - 1e-3) < one.gain_at(one.sigma(rate)) < best.gain * (1 + 1e-6)


@pytest.mark.parametrize("step", [None, 0.1])
@pytest.mark.parametrize("through", [0.0, 0.7])
@pytest.mark.parametrize("room", [1e-5, 1e-3])
def test_the_room_costs_no_more_than_was_given(
    step: float | None, through: float, room: float
) -> None:
    """The LMIs hold with a margin of that size, and the bound that P shows is so much larger."""
    path = vertex(step, through)
    one = OneVertex.of(*path, step=step)
    P = one.with_room(0.2, room)
    assert P is not None
    shown, _ = peak_bound(disturbance_channel(*path, sample_time=step), P, 0.2)
    sigma, (A, B) = one.sigma(0.2), path[:2]
    if step is None:
        left = np.block([[P @ A + A.T @ P + sigma * P, P @ B], [B.T @ P, -sigma * np.eye(2)]])
    else:
        G = np.hstack([A, B])
        left = G.T @ P @ G - np.diag([0, 0, 0, sigma, sigma])
        left[:3, :3] -= (1 - sigma) * P

    least = one.gain_at(sigma)
    assert least * (1 + 1e-7) < shown < least * (1 + room + 1e-6)
    assert np.linalg.eigvalsh(left)[-1] < -1e-3 * room * sigma * np.linalg.eigvalsh(P)[0]


@pytest.mark.parametrize("rate", [-0.1, 0.0, 0.5, 5.0])
def test_no_set_at_a_rate_that_the_vertex_has_not(rate: float) -> None:
    """The slowest mode decays at about 0.35 1/s."""
    assert OneVertex.of(*vertex(None), step=None).with_room(rate, 1e-4) is None


def test_an_unstable_vertex_has_no_rate() -> None:
    one = OneVertex.of(np.eye(1), np.eye(1), np.eye(1), np.zeros((1, 1)), step=None)

    assert one.best_rate() is None and one.with_room(0.1, 1e-4) is None
