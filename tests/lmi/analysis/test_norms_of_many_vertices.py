"""Norms of hundreds of vertices: few are given to the solver, and the bound holds for all."""

from __future__ import annotations

import numpy as np
import pytest
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

Floats = NDArray[np.float64]


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
