"""The energy gain by polynomial Lyapunov functions: published numbers, frozen systems, limits."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import pytest

from takagi.lmi import common_lyapunov, hinf_norm
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import family_gain, masses_and_spring, rolmip_pair


def frozen_gain(model: TSModel) -> float:
    h = np.array(
        [
            np.prod(list(product(*[(1 - w, w) for w in weights])), axis=1)
            for weights in product(np.linspace(0, 1, 4), repeat=3)
        ]
    )
    A, E, C = (np.tensordot(h, part, axes=1) for part in (model.A, model.E, model.C))
    s = 1j * np.logspace(-2, 1, 400)[:, None, None, None]
    response = C @ np.linalg.solve(s * np.eye(A.shape[1]) - A, np.broadcast_to(E, (400, *E.shape)))
    return float(np.abs(response).max())


def sampled(step: float) -> TSModel:
    """Two discrete vertices without a common P (ROLMIP manual, section 7.1), driven and seen."""
    return TSModel(
        rolmip_pair(), E=[[[1.0], [0.0]], [[0.0], [1.0]]], C=[[1.0, 0.5]], sample_time=step
    )


def gain_of(model: TSModel, **options: Any) -> float:
    gain = family_gain(model, **options).gain
    assert gain is not None
    return gain


@pytest.mark.parametrize(("degree", "gain"), [(0, 2.8429), (1, 1.0540)])
def test_masses_and_spring(degree: int, gain: float) -> None:
    """ROLMIP manual, table 2, LMI (15) by coefficients: 2.8429 with one P, 1.0540 with g = 1."""
    answer = family_gain(masses_and_spring(), degree=degree)

    assert answer.found and answer.gain is not None and answer.lyapunov_function is not None
    assert answer.gain == pytest.approx(gain, abs=1e-4)
    assert answer.lyapunov_function.members.shape == ((8 if degree else 1), 4, 4)


@pytest.mark.slow
def test_richer_polynomials_come_closer_to_the_frozen_systems() -> None:
    """From 1.0540 down to the largest response of constant parameters, reached by degree 2."""
    model = masses_and_spring()
    gains = [
        gain_of(model, degree=degree, polya=polya) for degree, polya in ((1, 0), (1, 1), (2, 0))
    ]
    frozen = frozen_gain(model)

    assert gains == sorted(gains, reverse=True)
    assert frozen <= gains[-1]
    assert gains[-1] == pytest.approx(frozen, rel=1e-5)


def test_degree_zero_is_the_gain_by_one_P() -> None:
    """``hinf_norm`` in continuous and in discrete time."""
    model = masses_and_spring()
    A = 0.9 * sampled(1.0).A
    B, C = sampled(1.0).E, [[1.0, 0.5]]

    assert family_gain(model, degree=0).gain == pytest.approx(hinf_norm(model).gain, rel=1e-5)
    assert family_gain(TSModel(A, E=B, C=C, sample_time=1.0), degree=0).gain == pytest.approx(
        hinf_norm(A, B, C, sample_time=1.0).gain, rel=1e-5
    )


@pytest.mark.parametrize("step", [None, 0.1])
def test_one_system_has_its_own_norm(step: float | None) -> None:
    """1 / (s^2 + 0.2 s + 1): 1 / (2 d sqrt(1 - d^2)) with d = 0.1; sampled, by its responses."""
    A, B, C = np.array([[0.0, 1.0], [-1.0, -0.2]]), np.array([[0.0], [1.0]]), [[1.0, 0.0]]
    peak = 1 / (0.2 * np.sqrt(1 - 0.01))
    if step is not None:
        A, B = np.eye(2) + step * A, step * B
        z = np.exp(1j * np.linspace(0.05, 0.15, 20001))[:, None, None]
        peak = np.abs(
            np.array(C) @ np.linalg.solve(z * np.eye(2) - A, np.broadcast_to(B, (20001, 2, 1)))
        ).max()
    answer = family_gain(TSModel([A], E=[B], C=[C], sample_time=step), degree=2)

    assert answer.gain == pytest.approx(peak, rel=1e-5)


@pytest.mark.parametrize(("step", "gain"), [(None, 3.0), (1.0, 2.3)])
def test_what_goes_straight_through_counts(step: float | None, gain: float) -> None:
    """(s + 3) / (s + 1) has the norm 3 at rest; y = x + 0.3 w of x+ = x / 2 + w has 2.3."""
    A, B = (-1.0, 2.0) if step is None else (0.5, 1.0)
    D = 1.0 if step is None else 0.3
    model = TSModel([[[A]], [[A]]], E=[[B]], C=[[1.0]], sample_time=step)
    answer = family_gain(model, F=D, rate_bounds=np.inf)

    assert answer.gain == pytest.approx(gain, rel=1e-5)


def test_discrete_vertices_without_a_common_P() -> None:
    """One P finds no bound; P of degree 1 does, above the response of every blend."""
    model = sampled(0.5)
    answer = family_gain(model)
    h = np.linspace(0, 1, 21)
    h = np.stack([h, 1 - h], axis=1)
    A, E, C = (np.tensordot(h, part, axes=1) for part in (model.A, model.E, model.C))
    z = np.exp(1j * np.linspace(0, np.pi, 500))[:, None, None, None]
    response = C @ np.linalg.solve(z * np.eye(2) - A, np.broadcast_to(E, (500, *E.shape)))

    assert family_gain(model, degree=0).status == "infeasible"
    assert answer.gain is not None
    assert np.abs(response).max() <= answer.gain
    assert gain_of(model, degree=4) <= 0.6 * answer.gain


@pytest.mark.slow
@pytest.mark.parametrize(
    "model", [masses_and_spring(), sampled(0.5)], ids=["continuous", "discrete"]
)
def test_the_faster_the_parameters_the_larger_the_gain(model: TSModel) -> None:
    rates = [0.0, 0.05, 0.5]
    gains = [gain_of(model, rate_bounds=rate) for rate in rates]

    assert gains == sorted(gains)
    assert gains[0] < gains[-1]


def test_energy_of_a_sampled_motion() -> None:
    """Random inputs and steps of at most 0.25: sum y^2 <= gamma^2 sum w^2."""
    model = sampled(0.5)
    gain = family_gain(model, rate_bounds=0.5).gain
    assert gain is not None
    rng = np.random.default_rng(0)
    for _ in range(20):
        x, share, put, got = np.zeros(2), rng.random(), 0.0, 0.0
        pull = rng.standard_normal(2)
        for _ in range(60):
            h = np.array([share, 1 - share])
            A, E = np.tensordot(h, model.A, axes=1), np.tensordot(h, model.E, axes=1)[:, 0]
            w = float(pull @ x) + 0.3 * rng.standard_normal()
            y = float((model.C[0] @ x)[0])
            x, put, got = A @ x + E * w, put + w * w, got + y * y
            share = float(np.clip(share + rng.uniform(-0.25, 0.25), 0, 1))
        assert got <= gain**2 * put


def test_no_finite_bound_is_said() -> None:
    unstable = family_gain(
        TSModel([[[-1, 10], [0, -1]], [[-1, 0], [10, -1]]], E=[[1], [0]], C=[[1, 0]])
    )
    answer = family_gain(sampled(0.5), degree=0)

    assert unstable.diagnosis.startswith("the mean of rules 1 and 2 of 2 alone rules it out")
    assert not common_lyapunov(sampled(0.5)).found
    assert answer.gain is None and "no P(h) by these LMIs" in answer.diagnosis


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"degree": -1}, "degree is -1"),
        ({"polya": 0.5}, "polya is 0.5"),
        ({"rate_bounds": -1.0}, "rate_bounds"),
    ],
)
def test_misuse_is_said(options: Mapping[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        family_gain(TSModel([[[0.0, 1.0], [-1.0, -1.0]]], E=[[0.0], [1.0]], C=[[1, 0]]), **options)
