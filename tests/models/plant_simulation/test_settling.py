"""Settling of many motions at once: against formulas, and against motions integrated one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.models import Plant, load_model, sector_model
from takagi.models.laws.pdc import OutputFeedback, PdcLaw
from takagi.models.plant_simulation.settling import SETTLED, ManyMotions
from tests.plant_files import filed_plant

PENDULUM = """
format = 1
kind = "plant"
name = "Pendulum"
units = "unchecked"
measured = ["theta"]
[states]
theta = { range = [-1, 1] }
omega = { range = [-4, 4] }
[inputs]
u = { }
[equations]
theta = "omega"
omega = "19.62*sin(theta) + u"
"""


def motions_of(name: str, limits: list[float] | None = None) -> ManyMotions:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    motions = ManyMotions.of(sector_model(plant), None if limits is None else np.array(limits))
    assert motions is not None
    return motions


def test_a_linear_loop_settles_when_its_exponential_says_so() -> None:
    """x1' = x2, x2' = -2 x2 - x1 from (x, -x): x(t) = x exp(-t), 2 % after ln 50."""
    motions = motions_of("ball_and_beam")
    linear = ManyMotions(motions.model, None, lambda x1, x2, u: [x2, u], motions.premises)
    starts = np.array([[1.0, 0.5], [-1.0, -0.5]])
    gains = np.array([[[1.0, 2.0]]])
    times = linear.settling_times(gains, starts, np.array([1.0, 1.0]), 10.0)
    assert times == pytest.approx([np.log(50), np.log(25)], abs=0.02)


def test_a_nonlinear_loop_agrees_with_motions_one_by_one() -> None:
    """The pendulum on a cart, one gain for all rules, cut inputs: scipy's Runge-Kutta 5(4)."""
    limit = 400.0
    motions = motions_of("cart_pole", [limit])
    gains = np.array([[[-3000.0, -900.0]]] * 16)
    starts = np.array([[0.2, -0.1], [0.0, 1.0]])
    reach = np.array([0.4, 2.0])
    times = motions.settling_times(gains, starts, reach, 6.0)

    def rate(_: float, x: np.ndarray) -> list[float]:
        u = float(np.clip(3000 * x[0] + 900 * x[1], -limit, limit))
        inertia = 2 / 3 - np.cos(x[0]) ** 2 / 10
        turning = 9.8 * np.sin(x[0]) - x[1] ** 2 * np.sin(2 * x[0]) / 20
        return [x[1], (turning - u * np.cos(x[0]) / 10) / inertia]

    for start, time in zip(starts.T, times, strict=True):
        run = solve_ivp(rate, (0, 6), start, rtol=1e-9, atol=1e-12, max_step=0.003)
        off = np.flatnonzero(np.any(np.abs(run.y) > SETTLED * reach[:, None], axis=0))
        assert time == pytest.approx(run.t[off[-1]], abs=0.02)


def test_a_loop_with_an_observer_agrees_with_motions_one_by_one() -> None:
    """The flexible link by its equations, weights at the estimate: scipy's Runge-Kutta 5(4)."""
    motions = motions_of("flexible_link", [20.0])
    n, rest = 4, (np.zeros(4), np.zeros(1))
    K = np.array([[[12.0, 1.1, 1.4, 3.3]], [[11.0, 1.0, 1.2, 3.0]]])
    L = np.array([[[16.0], [42.0], [14.0], [12.0]]])
    law = OutputFeedback(PdcLaw(motions.model, K, *rest), L, (0,), at_estimate=True)
    start = np.array([0.5, -1.0, 0.3, 0.4])
    known = np.array([0.5, 0.0, 0.0, 0.0])
    reach = np.array([1.6, 7.8, 0.8, 2.8])
    both = np.concatenate([start, known])
    times = motions.settling_times(law, np.array([both, -both]).T, reach, 12.0)

    (premise,) = motions.model.premises
    low, high = float(premise.lower), float(premise.upper)

    def link(x: np.ndarray, u: float) -> np.ndarray:
        motor = 48.6 * (x[2] - x[0]) - 1.25 * x[1] + 21.6 * u
        return np.array([x[1], motor, x[3], -19.5 * (x[2] - x[0]) - 3.33 * np.sin(x[2])])

    def rate(_: float, z: np.ndarray) -> np.ndarray:
        x, s = z[:n], z[n:]
        h = (np.sinc(s[2] / np.pi) - low) / (high - low)
        u = float(np.clip(-((1 - h) * K[0] + h * K[1])[0] @ s, -20, 20))
        return np.concatenate([link(x, u), link(s, u) + L[0, :, 0] * (x[0] - s[0])])

    run = solve_ivp(rate, (0, 12), both, rtol=1e-9, atol=1e-12, max_step=0.003)
    off = np.flatnonzero(np.any(np.abs(run.y[:n]) > SETTLED * reach[:, None], axis=0))
    assert times == pytest.approx([run.t[off[-1]]] * 2, abs=0.02)


def test_weights_of_what_is_measured_are_not_those_at_the_estimate(tmp_path: Path) -> None:
    """A pendulum whose angle is measured: theta'' = 9.81/0.5 sin(theta) + u, by scipy's RK45."""
    plant = filed_plant(tmp_path, PENDULUM)
    model = sector_model(plant)
    motions = ManyMotions.of(model, None)
    assert motions is not None
    K, L = np.array([[[60.0, 6.0]], [[25.0, 9.0]]]), np.array([[[6.0], [30.0]], [[9.0], [45.0]]])
    law = OutputFeedback(PdcLaw(model, K, np.zeros(2), np.zeros(1)), L, (0,), at_estimate=False)
    both, reach = np.array([0.9, 0.0, 0.0, 1.0]), np.array([1.0, 4.0])
    (time,) = motions.settling_times(law, both[:, None], reach, 12.0)

    (premise,) = model.premises
    low, high = float(premise.lower), float(premise.upper)

    def rate(_: float, z: np.ndarray) -> list[float]:
        share = float(np.sinc(z[0] / np.pi))
        h, pull = (share - low) / (high - low), 19.62 * share
        mixed_K, mixed_L = (((1 - h) * M[0] + h * M[1]).ravel() for M in (K, L))
        u, off = -float(mixed_K @ z[2:]), z[0] - z[2]
        estimated = [z[3] + mixed_L[0] * off, pull * z[2] + u + mixed_L[1] * off]
        return [z[1], pull * z[0] + u, *estimated]

    run = solve_ivp(rate, (0, 12), both, rtol=1e-9, atol=1e-12, max_step=0.003)
    off = np.flatnonzero(np.any(np.abs(run.y[:2]) > SETTLED * reach[:, None], axis=0))
    assert time == pytest.approx(run.t[off[-1]], abs=0.02)


def test_a_motion_that_does_not_settle_takes_for_ever() -> None:
    motions = motions_of("cart_pole")
    idle = np.zeros((16, 1, 2))
    times = motions.settling_times(idle, np.array([[0.1, 0.0], [0.0, 0.0]]), np.ones(2), 5.0)
    assert times[0] == np.inf and times[1] == 0.0


def test_samples_are_counted_in_discrete_time() -> None:
    """x(t + T) = x / 2: 2 % after six samples, for 2^-6 < 0.02 < 2^-5."""
    motions = motions_of("henon")
    step = motions.model.sample_time
    assert step is not None
    halving = ManyMotions(motions.model, None, lambda x, y, u: [x / 2 + u, y / 2], motions.premises)
    n = len(motions.model.states)
    gains = np.zeros((1, 1, n))
    times = halving.settling_times(gains, np.ones((n, 1)), np.ones(n), 50 * step)
    assert times == pytest.approx([6 * step])
