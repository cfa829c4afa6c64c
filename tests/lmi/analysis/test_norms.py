"""Energy gain, output variance and peak gain of given loops, in both kinds of time."""

from __future__ import annotations

from typing import Any

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
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.known_models import gain_of, planar_pair
from tests.lmi.norms import (
    frequency_norm,
    gramian_norm,
    hamiltonian_norm,
    sampled_gramian_norm,
    third_order,
)


def two_vertices(step: float | None = None, *, through: float = 1.0) -> TSModel:
    A = [[[-1.0, 2.0], [-3.0, -4.0]], [[-1.5, 1.0], [-1.0, -2.0]]]
    if step is not None:
        A = [[[0.5, 0.4], [-0.4, 0.5]], [[0.6, 0.1], [0.0, -0.4]]]
    return TSModel(
        A,
        [[[1.0, 0.0], [0.5, 1.0]], [[2.0, 0.0], [0.0, 1.0]]],
        C=[[[1.0, 0.0]], [[1.0, 0.5]]],
        D=through * np.array([[[0.1, 0.0]], [[0.0, -0.3]]]),
        sample_time=step,
    )


def bounded_real(model: TSModel, P: Floats, gamma: float) -> float:
    worst = -np.inf
    for A, B, C, D in zip(model.A, model.B, model.C, model.D, strict=True):
        state, cross, noise = P @ A + A.T @ P, P @ B, np.zeros((B.shape[1],) * 2)
        if model.sample_time is not None:
            state, cross, noise = A.T @ P @ A - P, A.T @ P @ B, B.T @ P @ B
        F = np.block(
            [
                [state, cross, C.T],
                [cross.T, noise - gamma * np.eye(len(noise)), D.T],
                [C, D, -gamma * np.eye(len(C))],
            ]
        )
        worst = max(worst, float(np.linalg.eigvalsh(F)[-1]) / np.abs(F).max())
    return worst


@pytest.mark.parametrize("step", [None, 0.1])
@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_the_energy_gain_is_what_its_quadratic_function_shows(
    scale: float, step: float | None
) -> None:
    """P meets the lemma in the model's own units a hair above the gain, and not below it."""
    s, plain = np.array([1.0, scale]), two_vertices(step)
    model = TSModel(
        plain.A * s / s[:, None], plain.B / s[:, None], C=plain.C * s, D=plain.D, sample_time=step
    )
    answer = hinf_norm(model)
    gain = gain_of(answer)
    assert answer.P is not None

    assert np.linalg.eigvalsh(answer.P)[0] > 0
    assert bounded_real(model, answer.P, gain * (1 + 1e-6)) < 0
    assert bounded_real(model, answer.P, gain * (1 - 1e-6)) > 0
    assert bounded_real(model, -answer.P, gain * (1 + 1e-6)) > 0


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, peak_gain])
def test_units_change_the_gain_by_their_ratio(norm: Any) -> None:
    """By d / c for w = d what, y = c yhat; time counts for a variance, by the root of its rate."""
    s, rate, d, c = np.array([3.0, 1e-5]), 1e-2, 1e6, 1e-5
    model = two_vertices(through=0.0 if norm is h2_norm else 1.0)
    other = TSModel(
        rate * model.A * s / s[:, None],
        rate * d * model.B / s[:, None],
        C=model.C * s / c,
        D=model.D * d / c,
    )
    expected = gain_of(norm(model)) * d / c * (np.sqrt(rate) if norm is h2_norm else 1.0)

    assert gain_of(norm(other)) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, peak_gain])
@pytest.mark.parametrize(("step", "mode"), [(None, 0.0), (1.0, -1.01)])
def test_a_vertex_that_is_not_stable_is_named(norm: Any, step: float | None, mode: float) -> None:
    A = [np.diag([-0.5, -0.2]), np.diag([mode, -0.2])]
    answer = norm(A, [[1.0], [1.0]], [[1.0, 0.0]], sample_time=step)

    assert answer.status == "infeasible"
    assert answer.gain is None and answer.P is None
    assert "vertex 2 of 2" in answer.diagnosis


def test_without_a_common_function_the_binding_vertices_are_named() -> None:
    no = h2_norm(planar_pair(10.0), [[0.0], [1.0]], [[1.0, 0.0]])

    assert no.status == "infeasible" and no.gain is None
    assert "no common P: the no rests on vertex" in no.diagnosis


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


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 6),
    q=st.integers(1, 3),
    p=st.integers(1, 3),
    slowest=st.floats(0.1, 2.0),
)
def test_one_vertex_against_the_gramian(seed: int, n: int, q: int, p: int, slowest: float) -> None:
    """For a linear system the variance bound is the norm that the Lyapunov equation gives."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + slowest) * np.eye(n)
    B, C = rng.standard_normal((n, q)), rng.standard_normal((p, n))

    assert gain_of(h2_norm(A, B, C)) == pytest.approx(gramian_norm(A, B, C), rel=1e-5)


def random_path(
    seed: int, n: int, q: int, p: int, radius: float
) -> tuple[Floats, Floats, Floats, Floats]:
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
def test_one_vertex_has_the_norms_of_the_sampled_system(
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


def test_the_variance_of_two_vertices_against_cvxpy() -> None:
    """The inequalities by hand in cvxpy, with a Schur complement, have the same least nu."""
    cp: Any = pytest.importorskip("cvxpy")
    model = two_vertices(through=0.0)
    P, nu = cp.Variable((2, 2), symmetric=True), cp.Variable()
    constraints = [P >> 0]
    for A, E, C in zip(model.A, model.B, model.C, strict=True):
        F = cp.bmat([[A.T @ P + P @ A, C.T], [C, -np.eye(1)]])
        constraints += [-(F + F.T) / 2 >> 0, cp.trace(E.T @ P @ E) <= nu]
    cp.Problem(cp.Minimize(nu), constraints).solve(solver="CLARABEL")

    assert gain_of(h2_norm(model)) == pytest.approx(float(np.sqrt(nu.value)), rel=1e-5)


def test_the_variance_is_what_its_quadratic_function_shows() -> None:
    """P meets both inequalities in the model's own units, the second with equality; -P does not."""
    S = np.array([1.0, 1e3])
    plain = two_vertices(through=0.0)
    model = TSModel(plain.A * S / S[:, None], plain.B / S[:, None], C=plain.C * S)
    answer = h2_norm(model)
    P = answer.P
    assert P is not None

    def excess(P: Floats) -> float:
        F = P @ model.A + model.A.transpose(0, 2, 1) @ P + model.C.transpose(0, 2, 1) @ model.C
        return float(np.linalg.eigvalsh(F * np.outer(1 / S, 1 / S))[:, -1].max())

    shown = max(float(np.trace(E.T @ P @ E)) for E in model.B)
    assert np.sqrt(shown) == pytest.approx(gain_of(answer), rel=1e-9)
    assert excess(P * (1 + 1e-9)) <= 1e-9
    assert excess(-P) > 0
    assert excess(P * (1 - 1e-3)) > 0


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
    model, rng = two_vertices(0.1), np.random.default_rng(0)
    orders = rng.integers(2, size=(40, 40))
    responses = [pulse_responses(model, order) for order in orders]
    energy = max(float(np.linalg.norm(response, 2)) for response in responses)
    pulses = max(float(np.linalg.norm(response[:, :2])) for response in responses)

    assert 0.5 * gain_of(hinf_norm(model)) < energy <= gain_of(hinf_norm(model))
    assert 0.5 * gain_of(h2_norm(model)) < pulses <= gain_of(h2_norm(model))


def test_feed_through_has_infinite_variance() -> None:
    A, B, C = third_order()
    D = np.diag([0.0, 0.25])
    answer = h2_norm(A, B, C, D)

    assert answer.status == "infeasible"
    assert answer.gain is None
    assert "vertex 1 of 1: D is not zero (largest entry 0.25)" in answer.diagnosis
    with pytest.raises(ModelError, match="infinite variance"):
        h2_norm_condition(A, B, C, D)


def test_the_disturbance_is_e_where_there_is_one() -> None:
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
    assert answer.status == "candidate", answer.diagnosis
    assert answer.gain is not None and answer.P is not None
    return answer.gain, answer.P


@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_rounds_reach_the_bound_of_all_vertices_at_once(sample_time: float | None) -> None:
    model = scattered(90, sample_time)
    energy = optimise(hinf_norm_condition(model))
    noise = optimise(h2_norm_condition(model))

    assert shown(hinf_norm(model))[0] == pytest.approx(energy.objective, rel=1e-4)
    assert shown(h2_norm(model))[0] == pytest.approx(np.sqrt(noise.objective), rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("sample_time", [None, 0.05])
def test_the_bound_holds_at_every_vertex(sample_time: float | None) -> None:
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
    model = scattered(300)
    A, B = model.A.copy(), model.E.copy()
    A[211] += 3 * np.eye(4)
    B[211] *= 10
    unstable = hinf_norm(A, B, model.C)
    loud = shown(hinf_norm(model.A, B, model.C))[0]

    assert unstable.status == "infeasible"
    assert "vertex 212 of 300" in unstable.diagnosis
    assert loud > 3 * shown(hinf_norm(model))[0]
