"""The peak-to-peak gain: closed forms, pulse responses, Lyapunov equations, trajectories."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_lyapunov
from scipy.optimize import minimize_scalar

from takagi.lmi import expressed, peak_gain, peak_gain_condition
from takagi.lmi.analysis.disturbance.channel import disturbance_channel
from takagi.lmi.analysis.disturbance.peak_to_peak import peak_bound
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.known_models import gain_of, planar_pair
from tests.lmi.norms import sampled


def two_vertices(sample_time: float | None = None) -> TSModel:
    A = [[[0.0, 1.0], [-1.0, -0.6]], [[0.0, 1.0], [-1.2, -1.0]]]
    B, C, D = [[0.0], [1.0]], [[1.0, 0.0]], [[[0.1]], [[-0.2]]]
    if sample_time is None:
        return TSModel(A, B, C=C, D=D)
    pairs = [sampled(np.array(vertex), np.array(B), sample_time) for vertex in A]
    return TSModel([a for a, _ in pairs], [b for _, b in pairs], C=C, D=D, sample_time=sample_time)


def star_norm(A: Floats, B: Floats, C: Floats) -> float:
    """Return the *-norm from Lyapunov equations: A X + X A' + lambda X + B B' / lambda = 0.

    Abedor, Nagpal and Poolla (1996): the least over lambda of the root of lambda_max(C X C').
    """
    one = np.eye(len(A))

    def reached(rate: float) -> float:
        X = solve_continuous_lyapunov(A + rate / 2 * one, -B @ B.T / rate)
        return float(np.sqrt(np.linalg.eigvalsh(C @ X @ C.T)[-1]))

    largest = -2 * float(np.linalg.eigvals(A).real.max())
    bounds = (1e-4 * largest, (1 - 1e-4) * largest)
    found: Any = minimize_scalar(reached, bounds=bounds, method="bounded")
    return float(found.fun)


@pytest.mark.parametrize(("a", "b", "d"), [(3.0, 2.0, 0.0), (0.2, -1.0, 0.0), (1.0, 2.0, -0.5)])
def test_one_state_has_its_peak_gain_exactly(a: float, b: float, d: float) -> None:
    """x' = -a x + b w, y = 5 x + d w: 5 |b| / a + |d|; sampled likewise over 1 - factor."""
    direct = [[d]]
    assert gain_of(peak_gain([[-a]], [[b]], [[5.0]], direct)) == pytest.approx(
        5 * abs(b) / a + abs(d), rel=1e-5
    )
    for factor in (0.9, -0.7, 0.0):
        answer = peak_gain([[factor]], [[b]], [[5.0]], direct, sample_time=0.1)
        expected = 5 * abs(b) / (1 - abs(factor)) + abs(d)
        assert gain_of(answer) == pytest.approx(expected, rel=1e-5)


@settings(max_examples=8)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(2, 5),
    q=st.integers(1, 2),
    p=st.integers(1, 2),
    slowest=st.floats(0.1, 1.0),
)
def test_one_vertex_has_the_star_norm(seed: int, n: int, q: int, p: int, slowest: float) -> None:
    """Without feed-through the least bound of one vertex is that of the Lyapunov equations."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + slowest) * np.eye(n)
    B, C = rng.standard_normal((n, q)), rng.standard_normal((p, n))

    assert gain_of(peak_gain(A, B, C)) == pytest.approx(star_norm(A, B, C), rel=2e-5)


def test_the_bound_lies_above_the_area_of_the_pulse_response() -> None:
    """The peak-to-peak gain of one vertex is the L1 norm of its pulse response.

    That of 1 / (s^2 + 2 z s + 1) is coth(z pi / (2 sqrt(1 - z^2))), z < 1; here z = 0.2.
    """
    area = 1 / np.tanh(0.1 * np.pi / np.sqrt(0.96))
    found = peak_gain([[0.0, 1.0], [-1.0, -0.4]], [[0.0], [1.0]], [[1.0, 0.0]])

    assert area < gain_of(found) < 1.2 * area


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_the_condition_itself_in_cvxpy(sample_time: float | None) -> None:
    """At the decay rate of the answer the condition, read by cvxpy, has the same least gamma."""
    model = two_vertices(sample_time)
    answer = peak_gain(model)
    assert answer.decay_rate is not None
    other = expressed(peak_gain_condition(model, decay_rate=answer.decay_rate), margin=0.0)
    other.problem().solve(solver="CLARABEL")

    least = float(other.values()["gamma"][0, 0, 0])
    assert gain_of(answer) == pytest.approx(least, rel=2e-5)


def test_no_decay_rate_does_better_than_the_one_found() -> None:
    model = two_vertices()
    best = peak_gain(model)
    assert best.decay_rate is not None
    for factor in (0.3, 0.8, 0.98, 1.02, 1.1):
        answer = peak_gain(model, decay_rate=factor * best.decay_rate)
        assert gain_of(answer) >= gain_of(best) * (1 - 1e-5)
        assert answer.decay_rate == factor * best.decay_rate
    fast = peak_gain(model, decay_rate=0.4)
    assert fast.status == "infeasible"
    assert "does not decay faster than 0.4 1/s" in fast.diagnosis
    growing = peak_gain([[0.1]], [[1.0]], [[1.0]])
    assert growing.status == "infeasible" and "0.1" in growing.diagnosis


def test_the_gain_is_what_p_and_the_rate_show() -> None:
    model = two_vertices()
    answer = peak_gain(model)
    assert answer.P is not None and answer.decay_rate is not None
    path = disturbance_channel(model)

    assert peak_bound(path, answer.P, answer.decay_rate)[0] == pytest.approx(
        gain_of(answer), rel=1e-5
    )
    assert peak_bound(path, -answer.P, answer.decay_rate)[0] == np.inf
    assert peak_bound(path, np.diag([1.0, 1.0]), answer.decay_rate)[0] > gain_of(answer)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "rate", "words"),
    [(10.0, None, "no common P"), (5.5, 0.5, "no common P at the decay rate 0.5 1/s")],
)
def test_a_rate_that_no_common_function_shows_is_a_reasoned_no(
    a: float, rate: float | None, words: str
) -> None:
    """Dayawansa and Martin's pairs: each vertex decays at 1 1/s, together far more slowly."""
    B, C = [[0.0], [1.0]], [[1.0, 0.0]]
    no = peak_gain(planar_pair(a), B, C, decay_rate=rate)

    assert no.status == "infeasible" and no.gain is None
    assert words in no.diagnosis
    assert peak_gain(planar_pair(5.5), B, C).found


def test_misuse_is_refused() -> None:
    with pytest.raises(ModelError, match=r"decay_rate is 0 1/s; it must be positive"):
        peak_gain(two_vertices(), decay_rate=0.0)
    with pytest.raises(ModelError, match=r"decay_rate is -1 1/s"):
        peak_gain_condition(two_vertices(), decay_rate=-1.0)
