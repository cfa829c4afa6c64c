"""Norms of x+ = A x + B w: frequencies, Gramians, python-control, pulses, the fast limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    Answer,
    h2_norm,
    h2_norm_condition,
    hinf_norm,
    hinf_norm_condition,
    optimise,
    peak_gain,
)
from takagi.lmi.analysis.disturbance.channel import disturbance_channel
from takagi.lmi.analysis.disturbance.energy_and_variance import energy_gain_of, variance_bound
from takagi.lmi.analysis.disturbance.peak_to_peak import peak_bound
from takagi.models import TSModel
from tests.lmi.known_models import gain_of
from tests.lmi.norms import frequency_norm, sampled_gramian_norm

Floats = NDArray[np.float64]


def two_vertices() -> TSModel:
    """Two vertices that share a quadratic function, with their own paths and feed-through."""
    return TSModel(
        [[[0.5, 0.4], [-0.4, 0.5]], [[0.6, 0.1], [0.0, -0.4]]],
        [[[1.0, 0.0], [0.5, 1.0]], [[2.0, 0.0], [0.0, 1.0]]],
        C=[[[1.0, 0.0]], [[1.0, 0.5]]],
        D=[[[0.1, 0.0]], [[0.0, -0.3]]],
        sample_time=0.1,
    )


def random_path(
    seed: int, n: int, q: int, p: int, radius: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return a stable random path of a given spectral radius."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    shapes = ((n, q), (p, n), (p, q))
    B, C, D = (rng.standard_normal(shape) for shape in shapes)
    return A, B, C, D


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 6),
    q=st.integers(1, 3),
    p=st.integers(1, 3),
    radius=st.floats(0.1, 0.97),
)
def test_one_vertex_has_the_norms_of_the_linear_system(
    seed: int, n: int, q: int, p: int, radius: float
) -> None:
    """Exact for a linear system: the peak over the unit circle, and the Gramian's trace."""
    A, B, C, D = random_path(seed, n, q, p, radius)

    found = gain_of(hinf_norm(A, B, C, D, sample_time=0.5))
    # The grid misses the peak by the square of its spacing.
    assert found == pytest.approx(frequency_norm(A, B, C, D), rel=1e-3)
    assert found >= frequency_norm(A, B, C, D) * (1 - 1e-9)
    variance = gain_of(h2_norm(A, B, C, D, sample_time=0.5))
    assert variance == pytest.approx(sampled_gramian_norm(A, B, C, D), rel=1e-5)


def pulse_responses(model: TSModel, order: NDArray[np.intp]) -> Floats:
    """Return the matrix that takes all of w to all of y along a switching sequence."""
    n, q = model.B.shape[1:]
    steps, p = len(order), model.C.shape[1]
    X, total = np.zeros((n, steps * q)), np.zeros((steps * p, steps * q))
    for k, vertex in enumerate(order):
        w = slice(k * q, (k + 1) * q)
        y = slice(k * p, (k + 1) * p)
        total[y] = model.C[vertex] @ X
        total[y, w] += model.D[vertex]
        X = model.A[vertex] @ X
        X[:, w] += model.B[vertex]
    return total


def test_switched_loops_keep_both_bounds() -> None:
    """Worst w for random switching, and the pulses of its first instant, stay below the bounds."""
    model, rng = two_vertices(), np.random.default_rng(0)
    orders = rng.integers(2, size=(40, 40))
    responses = [pulse_responses(model, order) for order in orders]
    energy = max(float(np.linalg.norm(response, 2)) for response in responses)
    pulses = max(float(np.linalg.norm(response[:, :2])) for response in responses)

    assert 0.5 * gain_of(hinf_norm(model)) < energy <= gain_of(hinf_norm(model))
    assert 0.5 * gain_of(h2_norm(model)) < pulses <= gain_of(h2_norm(model))


def test_the_quadratic_function_shows_the_gain_in_the_models_units() -> None:
    """With P, the lemma written out holds a hair above gamma and fails a hair below, and for -P."""
    s = np.array([1.0, 1e3])
    plain = two_vertices()
    model = TSModel(
        plain.A * s / s[:, None], plain.B / s[:, None], C=plain.C * s, D=plain.D, sample_time=0.1
    )
    answer = hinf_norm(model)
    assert answer.P is not None
    scale = np.concatenate([1 / s, np.ones(3)])

    def worst(P: Floats, gamma: float) -> float:
        largest = -np.inf
        for A, B, C, D in zip(model.A, model.B, model.C, model.D, strict=True):
            F = np.block(
                [
                    [A.T @ P @ A - P, A.T @ P @ B, C.T],
                    [B.T @ P @ A, B.T @ P @ B - gamma * np.eye(2), D.T],
                    [C, D, -gamma * np.eye(1)],
                ]
            )
            largest = max(largest, float(np.linalg.eigvalsh(F * np.outer(scale, scale))[-1]))
        return largest

    gain = gain_of(answer)
    assert worst(answer.P, gain * (1 + 1e-6)) < 0
    assert worst(answer.P, gain * (1 - 1e-6)) > 0
    assert worst(-answer.P, gain * (1 + 1e-6)) > 0


def test_a_vertex_outside_the_unit_circle_is_named() -> None:
    """A mode at -1.01 does not decay: no bound, and the answer says which vertex."""
    A = [[[0.5, 0.0], [0.0, 0.2]], [[-1.01, 0.0], [0.0, 0.2]]]
    for norm in (hinf_norm, h2_norm):
        answer = norm(A, [[1.0], [1.0]], [[1.0, 0.0]], sample_time=1.0)
        assert answer.status == "infeasible"
        assert answer.gain is None
        assert "vertex 2 of 2 is not stable" in answer.diagnosis


def scattered(count: int, sample_time: float | None = None) -> TSModel:
    """Vertices around one stable loop, each with its own path; they share a function by design."""
    rng = np.random.default_rng(4)
    S = rng.standard_normal((4, 4))
    S = S - S.T - np.eye(4)
    A = S + 0.5 * rng.uniform(-1, 1, (count, 1, 1)) * np.diag([1.0, -0.5, 0.3, 0.0])
    B = rng.standard_normal((4, 2)) + 0.2 * rng.standard_normal((count, 4, 2))
    C = rng.standard_normal((2, 4)) + 0.2 * rng.standard_normal((count, 2, 4))
    if sample_time is not None:
        A, B = np.eye(4) + sample_time * A, sample_time * B
    return TSModel(A, E=B, C=C, sample_time=sample_time)


def shown(answer: Answer) -> tuple[float, Floats]:
    """Return the gain and P of an answer that must have them."""
    assert answer.status == "candidate", answer.diagnosis
    assert answer.gain is not None and answer.P is not None
    return answer.gain, answer.P


@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_rounds_reach_the_bound_of_all_vertices_at_once(sample_time: float | None) -> None:
    """The same least gamma and nu as with every vertex given to the solver."""
    model = scattered(90, sample_time)
    energy = optimise(hinf_norm_condition(model))
    noise = optimise(h2_norm_condition(model))

    assert shown(hinf_norm(model))[0] == pytest.approx(energy.objective, rel=1e-4)
    assert shown(h2_norm(model))[0] == pytest.approx(np.sqrt(noise.objective), rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_the_bound_holds_at_every_vertex(sample_time: float | None) -> None:
    """P is held against all six hundred, by eigenvalues; with some vertices it shows less."""
    model = scattered(600, sample_time)
    path = disturbance_channel(model)
    energy, P = shown(hinf_norm(model))
    noise, R = shown(h2_norm(model))
    answer = peak_gain(model)
    peak, S = shown(answer)
    assert answer.decay_rate is not None

    assert energy_gain_of(path, P) == pytest.approx(energy, rel=1e-9)
    assert np.sqrt(variance_bound(path, R)[0]) == pytest.approx(noise, rel=1e-9)
    assert peak_bound(path, S, answer.decay_rate)[0] <= peak * (1 + 1e-9)
    few = path.at(np.arange(20))
    assert energy_gain_of(few, P) < energy
    assert np.sqrt(variance_bound(few, R)[0]) < noise


def test_one_bad_vertex_among_many_is_found() -> None:
    """A vertex that is not stable, or one that has a path ten times the others'."""
    model = scattered(300)
    A, B = model.A.copy(), model.E.copy()
    A[211] += 3 * np.eye(4)
    B[211] *= 10
    unstable = hinf_norm(A, B, model.C)
    loud = shown(hinf_norm(model.A, B, model.C))[0]

    assert unstable.status == "infeasible"
    assert "vertex 212 of 300" in unstable.diagnosis
    assert loud > 3 * shown(hinf_norm(model))[0]
