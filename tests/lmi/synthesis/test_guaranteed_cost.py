"""Guaranteed cost: one vertex is LQR; several share a gain whose cost is above each one's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.lmi.gains.cost.regulator import guaranteed_cost_condition, guaranteed_cost_gain
from takagi.models import Floats


def riccati(A: Floats, B: Floats, x: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Return (P, K) of LQR for weights of one over the squares of the ranges."""
    Q, R = np.diag(1 / x**2), np.diag(1 / u**2)
    P = np.asarray(solve_continuous_are(A, B, Q, R), dtype=np.float64)
    return P, np.asarray(np.linalg.solve(R, B.T @ P), dtype=np.float64)


def vertices() -> tuple[Floats, Floats]:
    """Return an integrating effort loop with a range of stiffness and gain."""
    A = np.array([[[a, 0.0], [-1.0, 0.0]] for a in (-0.1, 0.05)])
    B = np.array([[[-g], [0.0]] for g in (0.9, 1.1)])
    return A, B


def cost(A: Floats, B: Floats, K: Floats, x: Floats, u: Floats) -> float:
    """Return the mean cost over the unit sphere of states over their ranges, by Lyapunov."""
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
