"""Guaranteed quadratic cost by PDC in both times: Riccati equations, cvxpy, blends, units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov, solve_discrete_are

from takagi.lmi import Design, h2_norm, lqr_pdc, lqr_pdc_condition, structured_pdc
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.lmi.gains.cost.regulator import guaranteed_cost_condition, guaranteed_cost_gain
from takagi.models import Floats, ModelError, Premise, TSModel
from tests.lmi.compleib import SYSTEMS
from tests.lmi.known_models import cost_of, tanaka_wang_rules, three_rules
from tests.lmi.norms import sampled

ALL = ("common-gain", "wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang")


def two_rules(step: float | None = None) -> TSModel:
    """Tanaka and Wang (2001), page 58, with b = 3; with ``step`` each rule sampled."""
    model = tanaka_wang_rules(b=3.0)
    if step is None:
        return model
    rules = [sampled(a, b, step) for a, b in zip(model.A, model.B, strict=True)]
    return TSModel([a for a, _ in rules], [b for _, b in rules], sample_time=step)


def benchmark(name: str) -> tuple[Floats, Floats, Floats, Floats]:
    """Return A, B, Q, R of a plant of COMPleib; u = v - R^-1 N' x takes the cross weight N away."""
    system = SYSTEMS[name]()
    R, N = system.D12.T @ system.D12, system.C1.T @ system.D12
    shift = np.linalg.solve(R, N.T)
    return system.A - system.B @ shift, system.B, system.C1.T @ system.C1 - N @ shift, R


def worst_excess(model: TSModel, design: Design, Q: Floats, R: Floats) -> float:
    """Of He(P G) + Q + K(h)' R K(h), or G'PG - P + Q + K(h)' R K(h); G = A(h) - B(h) K(h)."""
    K, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(len(K)), 200)
    h = np.concatenate([h, np.eye(len(K))])
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    loop = A - B @ K
    closed = P @ loop
    rate = closed + closed.transpose(0, 2, 1)
    if model.sample_time is not None:
        rate = loop.transpose(0, 2, 1) @ closed - P
    spent = Q + K.transpose(0, 2, 1) @ R @ K
    total = rate + spent
    sizes = np.linalg.norm(spent, 2, axis=(1, 2))
    return float((np.linalg.eigvalsh(total)[:, -1] / sizes).max())


@pytest.mark.parametrize("name", ["NN2", "NN4", "REA1"])
def test_benchmark_plants(name: str) -> None:
    """COMPleib: cost = (H2 optimum)^2, and ``h2_norm`` of the closed loop is that optimum."""
    A, B, Q, R = benchmark(name)
    design = lqr_pdc(TSModel([A], B), Q, R)
    K, _ = design.require()
    C = np.concatenate([np.sqrt(Q), -np.sqrt(R) @ K[0]])

    assert np.sqrt(cost_of(design)) == pytest.approx(SYSTEMS[name]().h2, rel=1e-5)
    assert h2_norm(A - B @ K[0], np.eye(len(A)), C).gain == pytest.approx(
        SYSTEMS[name]().h2, rel=1e-5
    )


@settings(max_examples=12)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 6), rank=st.integers(1, 6), m=st.integers(1, 2))
def test_one_rule_is_the_linear_quadratic_regulator(seed: int, n: int, rank: int, m: int) -> None:
    """scipy's Riccati equation gives the same cost, and the gains to the root of its accuracy."""
    rng = np.random.default_rng(seed)
    m, rank = min(m, n), min(rank, n)
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    F = rng.standard_normal((rank, n))
    G = rng.standard_normal((m, m))
    Q, R = F.T @ F, G.T @ G + 0.1 * np.eye(m)
    P = solve_continuous_are(A, B, Q + 1e-9 * np.eye(n), R)
    design = lqr_pdc(TSModel([A], B), Q, R)

    assert cost_of(design) == pytest.approx(float(np.trace(P)), rel=1e-5)
    K = np.linalg.solve(R, B.T @ P)
    np.testing.assert_allclose(design.require()[0][0], K, atol=5e-3 * np.abs(K).max())


@settings(max_examples=12)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 5),
    m=st.integers(1, 2),
    step=st.sampled_from([1.0, 1e-2, 1e-4]),
)
def test_one_rule_is_the_discrete_regulator(seed: int, n: int, m: int, step: float) -> None:
    """scipy's discrete Riccati equation gives the same cost, and the gains to its square root."""
    rng = np.random.default_rng(seed)
    m = min(m, n)
    A, B = sampled(rng.standard_normal((n, n)), rng.standard_normal((n, m)), step)
    F = rng.standard_normal((n, n))
    Q, R = step * F.T @ F, step * np.eye(m)
    P = solve_discrete_are(A, B, Q, R)
    design = lqr_pdc(TSModel([A], B, sample_time=step), Q, R)

    assert cost_of(design) == pytest.approx(float(np.trace(P)), rel=1e-5)
    K = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    np.testing.assert_allclose(design.require()[0][0], K, atol=5e-3 * np.abs(K).max())


@pytest.mark.parametrize("step", [None, 0.05])
def test_the_cost_holds_for_every_blend(step: float | None) -> None:
    """V' + x'Qx + u'Ru <= 0 at random memberships and corners; not for a P that is 1 % smaller."""
    Q, R, model = np.eye(2), np.eye(1), two_rules(step)
    for relaxation in ALL:
        design = lqr_pdc(model, Q, R, relaxation=relaxation)
        assert worst_excess(model, design, Q, R) <= 1e-9
    smaller = type(design)(
        gains=design.gains,
        P=0.99 * design.require()[1],
        decay_rate=0.0,
        margin=design.margin,
        relaxation=design.relaxation,
        answer=design.answer,
    )
    assert worst_excess(model, smaller, Q, R) > 0


def test_rules_that_can_hardly_be_stabilised() -> None:
    """Three rules, b = -2: costs a thousand times those of one rule alone, or a reasoned no."""
    design = lqr_pdc(three_rules(-2.0), np.eye(2), [[1.0]], relaxation="polya-2")
    no = lqr_pdc(three_rules(-2.0), np.eye(2), [[1.0]], relaxation="wang-tanaka-griffin")

    assert cost_of(design) > 1e3
    assert worst_excess(three_rules(-2.0), design, np.eye(2), np.eye(1)) <= 1e-9
    assert no.status == "infeasible"
    assert no.gains is None and no.cost is None
    assert "rule" in no.answer.diagnosis and "liu-zhang" in no.answer.diagnosis
    assert "decay rate" not in no.answer.diagnosis


@pytest.mark.parametrize(
    ("s", "step"),
    [(np.array([1.0, 1e4]), None), (np.array([3e-5, 0.1]), None), (np.array([1.0, 1e4]), 0.05)],
)
def test_units_of_states_inputs_time_and_cost_do_not_matter(s: Floats, step: Any) -> None:
    model, tau, unit = two_rules(step), 1e3, 1e-4
    rate = 50.0 if step is None else 1.0
    Q, R = np.diag([1.0, 4.0]), np.array([[0.25]])
    plain = lqr_pdc(model, Q, R)
    other = lqr_pdc(
        TSModel(
            rate * model.A * s / s[:, None], rate * tau * model.B / s[:, None], sample_time=step
        ),
        unit * Q * s * s[:, None],
        unit * R * tau**2,
        deviations=1 / s,
    )

    assert cost_of(other) == pytest.approx(unit / rate * cost_of(plain), rel=1e-5)
    ours, theirs = plain.require()[0], tau * other.require()[0] / s
    np.testing.assert_allclose(theirs, ours, atol=1e-2 * np.abs(ours).max())


def test_deviations_weigh_the_initial_states() -> None:
    """One rule: the cost is trace L' P L of the Riccati solution, for deviations and for L."""
    A, B, Q, R = benchmark("REA1")
    P = solve_continuous_are(A, B, Q, R)
    d = np.array([1.0, 0.1, 3.0, 10.0])
    L = np.tril(np.ones((4, 4)))

    by_vector = lqr_pdc(TSModel([A], B), Q, R, deviations=d)
    by_matrix = lqr_pdc(TSModel([A], B), Q, R, deviations=L)
    assert cost_of(by_vector) == pytest.approx(float(d**2 @ np.diag(P)), rel=1e-5)
    assert cost_of(by_matrix) == pytest.approx(float(np.trace(L.T @ P @ L)), rel=1e-5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"Q": [[1.0, 1.0], [0.0, 1.0]]}, "Q is not symmetric"),
        ({"Q": -np.eye(2)}, "Q has the eigenvalue -1; it must be positive semidefinite"),
        ({"Q": 1j * np.eye(2)}, "Q cannot be read"),
        ({"R": None}, "R cannot be read"),
        ({"Q": np.eye(3)}, r"Q has shape \(3, 3\); \(2, 2\) is needed"),
        ({"R": [[0.0]]}, "R has the eigenvalue 0; it must be positive definite"),
        ({"R": [[np.nan]]}, "R.*is nan"),
        ({"relaxation": "tanaka-wong"}, "mean 'tanaka-wang'"),
        ({"deviations": [1.0, -1.0]}, r"deviations\[1\] is -1"),
        ({"deviations": np.eye(3)}, r"deviations has shape \(3, 3\)"),
    ],
)
def test_weights_that_make_no_sense(change: dict[str, Any], message: str) -> None:
    given_ = {"Q": np.eye(2), "R": [[1.0]], **change}
    with pytest.raises(ModelError, match=message):
        lqr_pdc(two_rules(), **given_)
    with pytest.raises(ModelError, match=message):
        lqr_pdc_condition(two_rules(), **given_)


@pytest.fixture
def model() -> TSModel:
    corners = [(a, b) for a in (0.0, 1.0) for b in (0.0, 1.0)]
    return TSModel(
        [[[0.2 + 0.5 * a, 1.0], [0.3 * b, -0.1]] for a, b in corners],
        [[[0.2 * a], [1.0 + 0.4 * b]] for a, b in corners],
        premises=[Premise("a", 0, 1), Premise("b", 0, 1)],
    )


def spent(model: TSModel, K: Floats, P: Floats, z: Floats) -> float:
    h = model.memberships(z)
    gain = np.tensordot(h, K, axes=1)
    A, B = (np.tensordot(h, stack, axes=1) for stack in (model.A, model.B))
    moved = P @ (A - B @ gain)
    return float(np.linalg.eigvalsh(moved + moved.T + np.eye(2) + gain.T @ gain)[-1])


def test_a_cost_by_products_of_premises(model: TSModel) -> None:
    product = lqr_pdc(model, np.eye(2), np.eye(1), relaxation="product")
    pairs = lqr_pdc(model, np.eye(2), np.eye(1), relaxation="wang-tanaka-griffin")
    assert product.cost is not None and pairs.cost is not None
    assert product.cost <= pairs.cost * (1 + 1e-5)
    K, P = product.require()
    grid = np.linspace(0.0, 1.0, 9)
    worst = max(spent(model, K, P, np.array([a, b])) for a in grid for b in grid)
    assert worst <= 1e-6 * np.linalg.norm(P)


@pytest.mark.slow
def test_structured_gains_by_products_of_premises(model: TSModel) -> None:
    found = structured_pdc(
        model,
        objective="cost",
        shared=["low", "low", "high", "high"],
        Q=np.eye(2),
        R=np.eye(1),
        relaxation="product",
        tolerance=1e-3,
    )
    K, P = found.require()
    assert np.array_equal(K[0], K[1]) and np.array_equal(K[2], K[3])
    assert found.value == pytest.approx(np.trace(P), rel=1e-9)
    assert spent(model, K, P, np.array([0.3, 0.8])) <= 1e-6 * np.linalg.norm(P)


def riccati(A: Floats, B: Floats, x: Floats, u: Floats) -> tuple[Floats, Floats]:
    Q, R = np.diag(1 / x**2), np.diag(1 / u**2)
    P = np.asarray(solve_continuous_are(A, B, Q, R), dtype=np.float64)
    return P, np.asarray(np.linalg.solve(R, B.T @ P), dtype=np.float64)


def vertices() -> tuple[Floats, Floats]:
    A = np.array([[[a, 0.0], [-1.0, 0.0]] for a in (-0.1, 0.05)])
    B = np.array([[[-g], [0.0]] for g in (0.9, 1.1)])
    return A, B


def cost(A: Floats, B: Floats, K: Floats, x: Floats, u: Floats) -> float:
    weight = np.diag(1 / x**2) + K.T @ np.diag(1 / u**2) @ K
    X = solve_continuous_lyapunov((A - B @ K).T, -weight)
    return float(np.trace(np.diag(x) @ X @ np.diag(x)))


@pytest.mark.parametrize(
    ("x", "u"), [((1.0, 1.0), (1.0,)), ((0.04, 0.5), (0.02,)), ((20.0, 20.0), (3.0,))]
)
def test_one_vertex_is_lqr(x: tuple[float, ...], u: tuple[float, ...]) -> None:
    """Kalman (1960) by the Riccati equation, and the LMI, give one gain: 1 % apart at most."""
    A, B = np.array([[0.2, 1.0], [-1.0, -0.3]]), np.array([[0.0], [1.0]])
    K = guaranteed_cost_gain(A[None], B[None], state_ranges=x, input_ranges=u)
    _, expected = riccati(A, B, np.array(x), np.array(u))

    assert K is not None
    assert pytest.approx(expected, rel=0.01) == K


def test_one_gain_serves_all_vertices_at_a_price() -> None:
    A, B = vertices()
    x, u = np.array([0.04, 0.5]), np.array([0.02])
    K = guaranteed_cost_gain(A, B, state_ranges=x, input_ranges=u)

    assert K is not None
    for vertex, column in zip(A, B, strict=True):
        assert np.linalg.eigvals(vertex - column @ K).real.max() < 0
        own = cost(vertex, column, K, x, u)
        best = np.trace(np.diag(x) @ riccati(vertex, column, x, u)[0] @ np.diag(x))
        assert best * (1 - 1e-6) <= own <= 1.5 * best


def test_the_condition_is_the_riccati_inequality() -> None:
    """At S = P^-1, M = K S of LQR the LMI is on its boundary; a larger S breaks it."""
    A, B = np.array([[0.2, 1.0], [-1.0, -0.3]]), np.array([[0.0], [1.0]])
    P, K = riccati(A, B, np.ones(2), np.ones(1))
    S = np.linalg.inv(P)
    condition = guaranteed_cost_condition(A[None], B[None])
    (rule,) = (lmi for lmi in condition.lmis if lmi.name == "rule")

    def room(factor: float) -> float:
        values = {"S": factor * S[None], "M": factor * (K @ S)[None], "W": P[None]}
        return float(smallest_eigenvalues(condition, rule, values).min())

    assert room(1.0) == pytest.approx(0, abs=1e-8)
    assert room(0.9) > 1e-4
    assert room(1.1) < -1e-4


@pytest.mark.slow
def test_vertices_that_no_gain_serves() -> None:
    """x' = x + u and x' = x - u: no u = -K x stabilises both, and the answer is None."""
    A, B = np.ones((2, 1, 1)), np.array([[[1.0]], [[-1.0]]])

    assert guaranteed_cost_gain(A, B, state_ranges=[1.0], input_ranges=[1.0]) is None
