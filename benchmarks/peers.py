"""The same questions, asked the way a control engineer would write them with other libraries.

Every function returns (seconds, margin): the time from plain arrays to numbers in hand, and the
largest t it found.  A peer that is not installed raises ``ImportError``: the table then says so.

The question about a common function:  A_i' P + P A_i <= -t w I,  t I <= P <= I,  t <= 1 largest.
About gains, by all pairs:  Theta_ii <= -t w I,  Theta_ij + Theta_ji <= -t w I,  t I <= Q <= I,
[[Q, M_i'], [M_i, nu I]] >= 0,  nu <= effort, with Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cvxpy_lyapunov(A: Floats, w: float) -> tuple[float, float]:
    """Ask for a common function by cvxpy and clarabel."""
    import cvxpy as cp

    began = time.perf_counter()
    n = A.shape[1]
    one = np.eye(n)
    P, t = cp.Variable((n, n), symmetric=True), cp.Variable()
    constraints = [P >> t * one, P << one, t <= 1]
    constraints += [Ai.T @ P + P @ Ai << -t * w * one for Ai in A]
    cp.Problem(cp.Maximize(t), constraints).solve(solver=cp.CLARABEL)
    return time.perf_counter() - began, float(t.value)


def picos_lyapunov(A: Floats, w: float) -> tuple[float, float]:
    """Ask for a common function by PICOS and CVXOPT."""
    import picos

    began = time.perf_counter()
    n = A.shape[1]
    problem = picos.Problem()
    P, t = picos.SymmetricVariable("P", n), picos.RealVariable("t")
    one = picos.I(n)
    problem.add_list_of_constraints([P >> t * one, P << one, t <= 1])
    for Ai in A:
        vertex = picos.Constant(Ai)
        problem.add_constraint(vertex.T * P + P * vertex << -t * w * one)
    problem.set_objective("max", t)
    problem.solve(solver="cvxopt")
    return time.perf_counter() - began, float(t.value)


def cvxpy_compensation(
    A: Floats, B: Floats, alpha: float, w: float, effort: float
) -> tuple[float, float]:
    """Ask for gains by cvxpy and clarabel."""
    import cvxpy as cp

    began = time.perf_counter()
    r, n, m = B.shape
    one = np.eye(n)
    Q, t, nu = cp.Variable((n, n), symmetric=True), cp.Variable(), cp.Variable()
    M = [cp.Variable((m, n)) for _ in range(r)]

    def loop(i: int, j: int) -> Any:
        G = A[i] @ Q - B[i] @ M[j]
        return G + G.T + 2 * alpha * Q

    constraints = [Q >> t * one, Q << one, t <= 1, nu <= effort]
    for i in range(r):
        constraints.append(loop(i, i) << -t * w * one)
        constraints.append(cp.bmat([[Q, M[i].T], [M[i], nu * np.eye(m)]]) >> 0)
        constraints += [loop(i, j) + loop(j, i) << -t * w * one for j in range(i + 1, r)]
    cp.Problem(cp.Maximize(t), constraints).solve(solver=cp.CLARABEL)
    return time.perf_counter() - began, float(t.value)


def picos_compensation(
    A: Floats, B: Floats, alpha: float, w: float, effort: float
) -> tuple[float, float]:
    """Ask for gains by PICOS and CVXOPT."""
    import picos

    began = time.perf_counter()
    r, n, m = B.shape
    one = picos.I(n)
    problem = picos.Problem()
    Q, t, nu = picos.SymmetricVariable("Q", n), picos.RealVariable("t"), picos.RealVariable("nu")
    M = [picos.RealVariable(f"M{i}", (m, n)) for i in range(r)]
    vertices = [(picos.Constant(Ai), picos.Constant(Bi)) for Ai, Bi in zip(A, B, strict=True)]

    def loop(i: int, j: int) -> Any:
        G = vertices[i][0] * Q - vertices[i][1] * M[j]
        return G + G.T + 2 * alpha * Q

    problem.add_list_of_constraints([Q >> t * one, Q << one, t <= 1, nu <= effort])
    for i in range(r):
        problem.add_constraint(loop(i, i) << -t * w * one)
        problem.add_constraint(((Q & M[i].T) // (M[i] & nu * picos.I(m))) >> 0)
        for j in range(i + 1, r):
            problem.add_constraint(loop(i, j) + loop(j, i) << -t * w * one)
    problem.set_objective("max", t)
    problem.solve(solver="cvxopt")
    return time.perf_counter() - began, float(t.value)


def cvxpy_rate(A: Floats, low: float, high: float, tolerance: float) -> tuple[float, float]:
    """Bisect for the largest decay rate, each problem written and compiled anew."""
    import cvxpy as cp

    began = time.perf_counter()
    n = A.shape[1]
    one = np.eye(n)
    while high - low > tolerance * high:
        alpha = (low + high) / 2
        P, t = cp.Variable((n, n), symmetric=True), cp.Variable()
        constraints = [P >> t * one, P << one, t <= 1]
        constraints += [Ai.T @ P + P @ Ai + 2 * alpha * P << -t * one for Ai in A]
        cp.Problem(cp.Maximize(t), constraints).solve(solver=cp.CLARABEL)
        low, high = (alpha, high) if t.value > 0 else (low, alpha)
    return time.perf_counter() - began, low


def cvxpy_rate_by_parameter(
    A: Floats, low: float, high: float, tolerance: float
) -> tuple[float, float]:
    """Bisect for the largest decay rate with alpha a parameter: compiled once (DPP)."""
    import cvxpy as cp

    began = time.perf_counter()
    n = A.shape[1]
    one = np.eye(n)
    P, t = cp.Variable((n, n), symmetric=True), cp.Variable()
    rate = cp.Parameter(nonneg=True)
    constraints = [P >> t * one, P << one, t <= 1]
    constraints += [Ai.T @ P + P @ Ai + 2 * rate * P << -t * one for Ai in A]
    problem = cp.Problem(cp.Maximize(t), constraints)
    while high - low > tolerance * high:
        rate.value = (low + high) / 2
        problem.solve(solver=cp.CLARABEL)
        low, high = (float(rate.value), high) if t.value > 0 else (low, float(rate.value))
    return time.perf_counter() - began, low


def cvxpy_energy_gain(plant: Any) -> tuple[float, float]:
    """Ask for the least H-infinity norm by cvxpy and clarabel: the textbook LMI, all pairs.

    Parameters
    ----------
    plant : A, B, C, D, E, one of each for every rule.
    """
    import cvxpy as cp

    began = time.perf_counter()
    A, B, C, D, E = plant
    (r, n, m), p, q = B.shape, C.shape[1], E.shape[2]
    Q, gamma = cp.Variable((n, n), symmetric=True), cp.Variable()
    M = [cp.Variable((m, n)) for _ in range(r)]

    def loop(i: int, j: int) -> Any:
        G, Z = A[i] @ Q - B[i] @ M[j], C[i] @ Q - D[i] @ M[j]
        w, z = gamma * np.eye(q), gamma * np.eye(p)
        rows = [[-G - G.T, -E[i], -Z.T], [-E[i].T, w, np.zeros((q, p))], [-Z, np.zeros((p, q)), z]]
        return cp.bmat(rows)

    constraints = [Q >> 0]
    for i in range(r):
        constraints.append(loop(i, i) >> 0)
        constraints += [loop(i, j) + loop(j, i) >> 0 for j in range(i + 1, r)]
    cp.Problem(cp.Minimize(gamma), constraints).solve(solver=cp.CLARABEL)
    return time.perf_counter() - began, float(gamma.value)


def cvxpy_variance(plant: Any) -> tuple[float, float]:
    """Ask for the least H2 norm by cvxpy and clarabel: the textbook LMI, all pairs."""
    import cvxpy as cp

    began = time.perf_counter()
    A, B, C, D, E = plant
    (r, n, m), p, q = B.shape, C.shape[1], E.shape[2]
    Q, nu = cp.Variable((n, n), symmetric=True), cp.Variable()
    M = [cp.Variable((m, n)) for _ in range(r)]
    W = [cp.Variable((q, q), symmetric=True) for _ in range(r)]

    def loop(i: int, j: int) -> Any:
        G, Z = A[i] @ Q - B[i] @ M[j], C[i] @ Q - D[i] @ M[j]
        return cp.bmat([[-G - G.T, -Z.T], [-Z, np.eye(p)]])

    constraints = [Q >> 0]
    for i in range(r):
        constraints += [cp.bmat([[W[i], E[i].T], [E[i], Q]]) >> 0, cp.trace(W[i]) <= nu]
        constraints.append(loop(i, i) >> 0)
        constraints += [loop(i, j) + loop(j, i) >> 0 for j in range(i + 1, r)]
    cp.Problem(cp.Minimize(nu), constraints).solve(solver=cp.CLARABEL)
    return time.perf_counter() - began, float(np.sqrt(nu.value))
