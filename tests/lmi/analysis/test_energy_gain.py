"""The energy gain by the bounded real lemma: published numbers, a Hamiltonian, cvxpy, units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import h2_norm, hinf_norm, hinf_norm_condition, peak_gain
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import gain_of, masses_and_spring
from tests.lmi.norms import hamiltonian_norm, third_order

Floats = NDArray[np.float64]


def two_vertices() -> TSModel:
    """Two stable vertices that share a quadratic function, with feed-through."""
    return TSModel(
        [[[-1.0, 2.0], [-3.0, -4.0]], [[-1.5, 1.0], [-1.0, -2.0]]],
        [[[1.0, 0.0], [0.5, 1.0]], [[2.0, 0.0], [0.0, 1.0]]],
        C=[[[1.0, 0.0]], [[1.0, 0.5]]],
        D=[[[0.1, 0.0]], [[0.0, -0.3]]],
    )


def bounded_real(model: TSModel, P: Floats, gamma: float) -> float:
    """Return the largest eigenvalue of the bounded real matrices, written out, scaled to 1."""
    worst = -np.inf
    for A, B, C, D in zip(model.A, model.B, model.C, model.D, strict=True):
        q, p = B.shape[1], C.shape[0]
        F = np.block(
            [
                [P @ A + A.T @ P, P @ B, C.T],
                [B.T @ P, -gamma * np.eye(q), D.T],
                [C, D, -gamma * np.eye(p)],
            ]
        )
        worst = max(worst, float(np.linalg.eigvalsh(F)[-1]) / np.abs(F).max())
    return worst


def test_mass_spring_with_one_quadratic_function() -> None:
    """ROLMIP manual, table 2, degree 0 in the parameters: 2.8429."""
    assert gain_of(hinf_norm(masses_and_spring())) == pytest.approx(2.8429, abs=6e-5)


def test_third_order_system_by_matlab() -> None:
    """python-control's sysnorm_test.py: 4.276759162964244, computed in MATLAB."""
    assert gain_of(hinf_norm(*third_order())) == pytest.approx(4.276759162964244, rel=2e-6)


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 6),
    q=st.integers(1, 3),
    p=st.integers(1, 3),
    slowest=st.floats(0.05, 2.0),
    through=st.sampled_from([0.0, 1.0]),
)
def test_one_vertex_against_the_hamiltonian(
    seed: int, n: int, q: int, p: int, slowest: float, through: float
) -> None:
    """For a linear system the lemma is exact: the Hamiltonian's bisection gives the same number."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + slowest) * np.eye(n)
    B, C = rng.standard_normal((n, q)), rng.standard_normal((p, n))
    D = through * rng.standard_normal((p, q))

    assert gain_of(hinf_norm(A, B, C, D)) == pytest.approx(hamiltonian_norm(A, B, C, D), rel=1e-5)


def test_two_vertices_against_cvxpy() -> None:
    """The lemma written by hand in cvxpy has the same least gamma."""
    cp: Any = pytest.importorskip("cvxpy")
    model = two_vertices()
    P, gamma = cp.Variable((2, 2), symmetric=True), cp.Variable()
    constraints = [P >> 0]
    for A, B, C, D in zip(model.A, model.B, model.C, model.D, strict=True):
        F = cp.bmat(
            [
                [A.T @ P + P @ A, P @ B, C.T],
                [B.T @ P, -gamma * np.eye(2), D.T],
                [C, D, -gamma * np.eye(1)],
            ]
        )
        constraints.append(-(F + F.T) / 2 >> 0)
    cp.Problem(cp.Minimize(gamma), constraints).solve(solver="CLARABEL")

    assert gain_of(hinf_norm(model)) == pytest.approx(float(gamma.value), rel=1e-5)


def test_the_gain_is_what_its_quadratic_function_shows() -> None:
    """P meets the lemma in the model's own units a hair above the gain, and not below it."""
    for scale in (1.0, 1e3):
        S = np.array([1.0, scale])
        plain = two_vertices()
        model = TSModel(plain.A * S / S[:, None], plain.B / S[:, None], C=plain.C * S, D=plain.D)
        answer = hinf_norm(model)
        gain = gain_of(answer)
        assert answer.P is not None

        assert np.linalg.eigvalsh(answer.P)[0] > 0
        assert bounded_real(model, answer.P, gain * (1 + 1e-6)) < 0
        assert bounded_real(model, answer.P, gain * (1 - 1e-6)) > 0
        assert bounded_real(model, -answer.P, gain * (1 + 1e-6)) > 0


def test_units_change_the_gain_by_their_ratio() -> None:
    """States and time leave the gain as it is; w = d what, y = c yhat multiply it by d / c."""
    model, s = masses_and_spring(), np.array([3.0, 0.1, 7.0, 1e5])
    rate, disturbance, output = 1e-2, 1e6, 1e-5
    other = TSModel(
        rate * model.A * s / s[:, None],
        E=rate * disturbance * model.E / s[:, None],
        C=model.C * s / output,
    )
    expected = gain_of(hinf_norm(model)) * disturbance / output

    assert gain_of(hinf_norm(other)) == pytest.approx(expected, rel=1e-5)


def test_the_disturbance_is_e_where_there_is_one() -> None:
    """With E the input and its feed-through play no part; without it the input disturbs."""
    A = [[[-2.0]]]
    both = TSModel(A, [[7.0]], C=[[1.0]], D=[[9.0]], E=[[3.0]])
    only_input = TSModel(A, [[7.0]], C=[[1.0]], D=[[9.0]])

    assert gain_of(hinf_norm(both)) == pytest.approx(1.5, rel=1e-6)
    assert gain_of(hinf_norm(only_input)) == pytest.approx(12.5, rel=1e-6)


def test_redundant_disturbances_and_outputs_are_welcome() -> None:
    """Five equal disturbances and three equal outputs: sqrt(5 * 3) times the gain of one pair."""
    A = -np.eye(2)
    one = gain_of(hinf_norm(A, np.ones((2, 1)), np.ones((1, 2))))

    many = gain_of(hinf_norm(A, np.ones((2, 5)), np.ones((3, 2))))
    assert many == pytest.approx(one * np.sqrt(15), rel=1e-5)


def test_a_vertex_that_is_not_stable_is_named() -> None:
    """An undamped vertex has no finite gain; the answer says which."""
    A = [[[0.0, 1.0], [-1.0, -1.0]], [[0.0, 1.0], [-1.0, 0.0]]]
    answer = hinf_norm(A, [[0.0], [1.0]], [[1.0, 0.0]])

    assert answer.status == "infeasible"
    assert answer.gain is None and answer.P is None
    assert "vertex 2 of 2 is not stable" in answer.diagnosis


def test_a_bound_far_from_the_least_is_not_passed_off_as_it() -> None:
    """Rates of 1e-3 and 1e4 1/s: either the gain, 1000, or no candidate at all."""
    answer = hinf_norm([[-1e-3, 1.0], [0.0, -1e4]], [[0.0], [1e4]], [[1.0, 0.0]])

    assert answer.gain is None or answer.gain == pytest.approx(1e3, rel=1e-3)
    assert answer.found or answer.diagnosis


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-np.eye(2), np.ones((2, 1))), "there is no output; C is needed"),
        ((-np.eye(2), None, np.ones((1, 2))), "no disturbance and no input"),
        ((-np.eye(2), np.ones((3, 1)), np.ones((1, 2))), r"B has shape \(3, 1\)"),
        ((-np.eye(2), np.ones((2, 1)), np.ones((1, 3))), r"C has shape \(1, 3\)"),
        ((-np.eye(2), np.ones((2, 1)), np.ones((1, 2)), np.ones((2, 2))), "D has shape"),
        ((-np.eye(2), np.full((2, 1), np.nan), np.ones((1, 2))), "B.*is nan"),
        ((-np.eye(2), np.zeros((2, 1)), np.ones((1, 2))), "B is zero at every vertex"),
        ((-np.eye(2), np.ones((2, 1)), np.zeros((1, 2))), "C is zero at every vertex"),
        ((np.zeros((0, 2, 2)), np.ones((2, 1)), np.ones((1, 2))), "no vertices"),
        ((two_vertices(), np.ones((2, 1))), "a model and B were given"),
    ],
)
def test_paths_that_make_no_sense(arguments: tuple[Any, ...], message: str) -> None:
    """Shapes, emptiness, entries and dead paths are told apart, in the builder too."""
    with pytest.raises(ModelError, match=message):
        hinf_norm(*arguments)
    with pytest.raises(ModelError, match=message):
        hinf_norm_condition(*arguments)


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, peak_gain])
@pytest.mark.parametrize("step", [None, 1.0])
@pytest.mark.parametrize(
    "A",
    [
        [np.diag([-0.5, -0.2])],
        [np.array([[-0.5, 0.0], [1.0, -0.2]])],
        [np.diag([-0.5, -0.2]), np.diag([-0.3, -0.6])],
    ],
)
def test_a_disturbance_that_never_reaches_the_output(norm: Any, step: float | None, A: Any) -> None:
    """x2 is pushed and x1 is seen: zero; with a share of x2 seen it is not."""
    E = [[0.0], [1.0]]
    found = norm(TSModel(A, E=E, C=[[1.0, 0.0]], sample_time=step))
    seen = norm(TSModel(A, E=E, C=[[1.0, 1.0]], sample_time=step))

    assert found.status == "candidate" and gain_of(found) < 1e-10
    assert np.linalg.eigvalsh(found.P)[0] > 0
    assert gain_of(seen) > 0.1
