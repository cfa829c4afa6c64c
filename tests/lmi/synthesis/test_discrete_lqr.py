"""Guaranteed cost in discrete time: Riccati equations, cvxpy, blends, fast sampling."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_are, solve_discrete_are

from takagi.lmi import Design, lqr_pdc
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import cost_of

Floats = NDArray[np.float64]
ALL = ("common-gain", "wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang")


def sampled(A: Floats, B: Floats, step: float) -> tuple[Floats, Floats]:
    """Return the step-invariant model of x' = A x + B u."""
    n, m = B.shape
    E = expm(step * np.block([[A, B], [np.zeros((m, n + m))]]))
    return E[:n, :n], E[:n, n:]


def two_rules(step: float = 0.05) -> TSModel:
    """Tanaka and Wang (2001), page 58, with b = 3, each rule sampled."""
    A = np.array([[[2.0, -10.0], [1.0, 0.0]], [[2.5, -10.0], [1.0, 0.0]]])
    B = np.array([[[1.0], [0.0]], [[3.0], [0.0]]])
    rules = [sampled(a, b, step) for a, b in zip(A, B, strict=True)]
    return TSModel([a for a, _ in rules], [b for _, b in rules], sample_time=step)


def worst_excess(model: TSModel, design: Design, Q: Floats, R: Floats) -> float:
    """Return the largest relative eigenvalue of A'PA - P + Q + K'RK, A = A(h) - B(h) K(h)."""
    K, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(len(K)), 200)
    h = np.concatenate([h, np.eye(len(K))])
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    loop = A - B @ K
    spent = Q + K.transpose(0, 2, 1) @ R @ K
    total = loop.transpose(0, 2, 1) @ P @ loop - P + spent
    sizes = np.linalg.norm(spent, 2, axis=(1, 2))
    return float((np.linalg.eigvalsh(total)[:, -1] / sizes).max())


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


def test_a_step_of_nothing_but_gain() -> None:
    """x+ = 2 x + u, Q = R = 1: P = 2 + sqrt 5 and K = 2 P / (1 + P), by hand."""
    design = lqr_pdc(TSModel([[[2.0]]], [[1.0]], sample_time=0.1), [[1.0]], [[1.0]])
    P = 2 + np.sqrt(5)

    assert cost_of(design) == pytest.approx(P, rel=2e-6)
    assert design.require()[0][0, 0, 0] == pytest.approx(2 * P / (1 + P), rel=1e-4)


@pytest.mark.parametrize("step", [1e-2, 1e-4])
def test_sampled_ever_faster_the_cost_is_the_integral(step: float) -> None:
    """With weights T Q and T R the cost tends to that of continuous time, to order T."""
    A, B = np.array([[0.2, 1.0], [-1.0, -0.3]]), np.array([[0.0], [1.0]])
    limit = float(np.trace(solve_continuous_are(A, B, np.eye(2), np.eye(1))))
    discrete = TSModel([sampled(A, B, step)[0]], sampled(A, B, step)[1], sample_time=step)
    design = lqr_pdc(discrete, step * np.eye(2), [[step]])

    assert cost_of(design) == pytest.approx(limit, abs=2 * step + 1e-5 * limit)


def test_two_rules_against_cvxpy() -> None:
    """All pairs in the Schur form of the literature, by hand in cvxpy, have the same least cost."""
    cp: Any = pytest.importorskip("cvxpy")
    model = two_rules(0.5)
    Q, R = np.diag([1.0, 4.0]), np.array([[0.25]])
    S, W = (cp.Variable((2, 2), symmetric=True) for _ in range(2))
    M = [cp.Variable((1, 2)) for _ in range(2)]
    F, G = np.sqrt(Q), np.sqrt(R)

    def theta(i: int, j: int) -> Any:
        loop = model.A[i] @ S - model.B[i] @ M[j]
        wide, tall = np.zeros((2, 2)), np.zeros((2, 1))
        block = [
            [-S, loop.T, S @ F.T, M[j].T @ G.T],
            [loop, -S, wide, tall],
            [F @ S, wide, -np.eye(2), tall],
            [G @ M[j], tall.T, tall.T, -np.eye(1)],
        ]
        return cp.bmat(block)

    def below(block: Any) -> Any:
        return -(block + block.T) / 2 >> 0

    bound = cp.bmat([[W, np.eye(2)], [np.eye(2), S]]) >> 0
    rules = [below(theta(i, i)) for i in range(2)]
    problem = cp.Problem(
        cp.Minimize(cp.trace(W)), [bound, *rules, below(theta(0, 1) + theta(1, 0))]
    )
    problem.solve(solver="CLARABEL")

    assert cost_of(lqr_pdc(model, Q, R)) == pytest.approx(float(problem.value), rel=1e-5)


def test_the_cost_holds_for_every_blend_and_along_trajectories() -> None:
    """V+ - V + x'Qx + u'Ru <= 0 at random memberships; sums along random schedules stay below."""
    Q, R, model = np.eye(2), np.eye(1), two_rules()
    for relaxation in ALL:
        design = lqr_pdc(model, Q, R, relaxation=relaxation)
        assert worst_excess(model, design, Q, R) <= 1e-9
    K, P = design.require()
    rng = np.random.default_rng(3)
    for _ in range(20):
        x0 = x = rng.standard_normal(2)
        total = 0.0
        for h in rng.dirichlet([0.3, 0.3], 400):
            u = -np.tensordot(h, K, axes=1) @ x
            total += float(x @ Q @ x + u @ R @ u)
            x = np.tensordot(h, model.A, axes=1) @ x + np.tensordot(h, model.B, axes=1) @ u
        assert total <= x0 @ P @ x0


def test_units_of_states_inputs_and_cost_do_not_matter() -> None:
    """In other units the gains are the same law and the cost the same number of cost units."""
    model, s, tau, unit = two_rules(), np.array([1.0, 1e4]), 1e3, 1e-4
    Q, R = np.diag([1.0, 4.0]), np.array([[0.25]])
    plain = lqr_pdc(model, Q, R)
    other = lqr_pdc(
        TSModel(model.A * s / s[:, None], tau * model.B / s[:, None], sample_time=0.05),
        unit * Q * s * s[:, None],
        unit * R * tau**2,
        deviations=1 / s,
    )

    assert cost_of(other) == pytest.approx(unit * cost_of(plain), rel=1e-5)
    ours, theirs = plain.require()[0], tau * other.require()[0] / s
    np.testing.assert_allclose(theirs, ours, atol=1e-2 * np.abs(ours).max())


def test_rules_that_no_gain_serves() -> None:
    """x+ = 2 x + u and x+ = 2 x - u with one gain: none, and the reason names rules."""
    model = TSModel([[[2.0]], [[2.0]]], [[[1.0]], [[-1.0]]], sample_time=1.0)
    no = lqr_pdc(model, [[1.0]], [[1.0]], relaxation="common-gain")

    assert no.status == "infeasible"
    assert no.gains is None and no.cost is None
    assert "rule" in no.answer.diagnosis and "decay rate" not in no.answer.diagnosis


def test_an_unstable_mode_out_of_reach_is_named() -> None:
    """|z| = 1.1 that no input moves: misuse, with the state's name."""
    model = TSModel(
        [np.diag([1.1, 1.0])], [[0.0], [1.0]], states=["drift [m]", "speed [m/s]"], sample_time=0.1
    )
    with pytest.raises(ModelError, match=r"the mode at 1.1.*drift \[m\]"):
        lqr_pdc(model, np.eye(2), [[1.0]])
