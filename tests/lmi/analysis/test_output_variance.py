"""The output variance under white noise: published numbers, Lyapunov equations, cvxpy, units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import h2_norm, h2_norm_condition
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import gain_of, planar_pair
from tests.lmi.norms import gramian_norm, third_order

Floats = NDArray[np.float64]


def two_vertices() -> TSModel:
    """Two stable vertices that share a quadratic function, each with its own path."""
    return TSModel(
        [[[-1.0, 2.0], [-3.0, -4.0]], [[-1.5, 1.0], [-1.0, -2.0]]],
        E=[[[1.0, 0.0], [0.5, 1.0]], [[2.0, 0.0], [0.0, 1.0]]],
        C=[[[1.0, 0.0]], [[1.0, 0.5]]],
    )


def test_third_order_system_by_matlab() -> None:
    """python-control's sysnorm_test.py: 2.237461821810309, computed in MATLAB."""
    assert gain_of(h2_norm(*third_order())) == pytest.approx(2.237461821810309, rel=2e-6)


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 6),
    q=st.integers(1, 3),
    p=st.integers(1, 3),
    slowest=st.floats(0.1, 2.0),
)
def test_one_vertex_against_the_gramian(seed: int, n: int, q: int, p: int, slowest: float) -> None:
    """For a linear system the bound is the norm that the Lyapunov equation gives."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + slowest) * np.eye(n)
    B, C = rng.standard_normal((n, q)), rng.standard_normal((p, n))

    assert gain_of(h2_norm(A, B, C)) == pytest.approx(gramian_norm(A, B, C), rel=1e-5)


def test_two_vertices_against_cvxpy() -> None:
    """The inequalities by hand in cvxpy, with a Schur complement, have the same least nu."""
    cp: Any = pytest.importorskip("cvxpy")
    model = two_vertices()
    P, nu = cp.Variable((2, 2), symmetric=True), cp.Variable()
    constraints = [P >> 0]
    for A, E, C in zip(model.A, model.E, model.C, strict=True):
        F = cp.bmat([[A.T @ P + P @ A, C.T], [C, -np.eye(1)]])
        constraints += [-(F + F.T) / 2 >> 0, cp.trace(E.T @ P @ E) <= nu]
    cp.Problem(cp.Minimize(nu), constraints).solve(solver="CLARABEL")

    assert gain_of(h2_norm(model)) == pytest.approx(float(np.sqrt(nu.value)), rel=1e-5)


def test_the_gain_is_what_its_quadratic_function_shows() -> None:
    """P meets both inequalities in the model's own units, the second with equality; -P does not."""
    S = np.array([1.0, 1e3])
    plain = two_vertices()
    model = TSModel(plain.A * S / S[:, None], E=plain.E / S[:, None], C=plain.C * S)
    answer = h2_norm(model)
    P = answer.P
    assert P is not None

    def excess(P: Floats) -> float:
        F = P @ model.A + model.A.transpose(0, 2, 1) @ P + model.C.transpose(0, 2, 1) @ model.C
        return float(np.linalg.eigvalsh(F * np.outer(1 / S, 1 / S))[:, -1].max())

    shown = max(float(np.trace(E.T @ P @ E)) for E in model.E)
    assert np.sqrt(shown) == pytest.approx(gain_of(answer), rel=1e-9)
    assert excess(P * (1 + 1e-9)) <= 1e-9
    assert excess(-P) > 0
    assert excess(P * (1 - 1e-3)) > 0


def test_units_change_the_gain_as_they_should() -> None:
    """States leave it as it is; time multiplies it by the root of the rate."""
    model, s = two_vertices(), np.array([3.0, 1e-5])
    rate, disturbance, output = 1e-2, 1e6, 1e-5
    other = TSModel(
        rate * model.A * s / s[:, None],
        E=rate * disturbance * model.E / s[:, None],
        C=model.C * s / output,
    )
    expected = gain_of(h2_norm(model)) * disturbance / output * np.sqrt(rate)

    assert gain_of(h2_norm(other)) == pytest.approx(expected, rel=1e-5)


def test_feed_through_has_infinite_variance() -> None:
    """D that is not zero is a no with its reason; the builder has nothing to pose."""
    A, B, C = third_order()
    D = np.diag([0.0, 0.25])
    answer = h2_norm(A, B, C, D)

    assert answer.status == "infeasible"
    assert answer.gain is None
    assert "vertex 1 of 1: D is not zero (largest entry 0.25)" in answer.diagnosis
    with pytest.raises(ModelError, match="infinite variance"):
        h2_norm_condition(A, B, C, D)


def test_unstable_and_uncommon_vertices_are_a_reasoned_no() -> None:
    """A vertex that does not decay is named; without a common P the binding vertices are."""
    B, C = [[0.0], [1.0]], [[1.0, 0.0]]
    unstable = h2_norm([[0.0, 1.0], [-1.0, 0.0]], B, C)
    apart = h2_norm(planar_pair(10.0), B, C)

    assert unstable.status == apart.status == "infeasible"
    assert "vertex 1 of 1 is not stable" in unstable.diagnosis
    assert "no common P: the no rests on vertex" in apart.diagnosis
    assert unstable.gain is None and apart.gain is None
