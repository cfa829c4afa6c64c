"""Problems that times are measured on: random, reproducible by their seed, of any size.

Plain functions that return arrays or conditions; nothing here solves or measures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import Condition
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, block, identity, matrix, trace
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.double_sum import double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named

Floats = NDArray[np.float64]


class Channelled(NamedTuple):
    """x' = A_i x + B_i u + E_i w, z = C_i x + D_i u; one of each for every rule."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    E: Floats


def scattered_rules(
    rules: int, states: int, inputs: int, seed: int = 1, spread: float = 0.02
) -> tuple[Floats, Floats]:
    """Return (A, B), (r, n, n) and (r, n, m), scattered around one controllable pair."""
    random = np.random.default_rng(seed)
    A = random.normal(size=(states, states)) / states**0.5
    B = random.normal(size=(states, inputs))
    return (
        A + spread * random.normal(size=(rules, states, states)),
        B + spread / 2 * random.normal(size=(rules, states, inputs)),
    )


def stable_vertices(count: int, states: int, seed: int = 1, spread: float = 0.4) -> Floats:
    """Return A_i = T (S + E_i) T^-1, (N, n, n), with S + S' <= -2 I and |E_i| <= spread < 1.

    P = T^-T T^-1 shows all of them stable, which nothing about the A_i tells at a glance.
    """
    random = np.random.default_rng(seed)
    S = random.normal(size=(states, states))
    S -= (np.linalg.eigvalsh(S + S.T)[-1] / 2 + 1.0) * np.eye(states)
    E = random.normal(size=(count, states, states))
    E *= spread / np.linalg.norm(E, 2, axis=(1, 2))[:, None, None]
    T = np.linalg.qr(random.normal(size=(states, states)))[0] * np.geomspace(1.0, 4.0, states)
    return np.asarray(T @ (S + E) @ np.linalg.inv(T))


def disturbed_rules(
    rules: int,
    states: int,
    inputs: int,
    disturbances: int,
    outputs: int,
    seed: int = 1,
    *,
    spread: float = 0.02,
) -> Channelled:
    """Return rules with a disturbance and an output that holds every input."""
    random = np.random.default_rng(seed)
    A, B = scattered_rules(rules, states, inputs, seed, spread)
    C = np.zeros((outputs, states))
    kept = min(states, outputs - inputs)
    C[range(kept), range(kept)] = 1.0
    D = np.zeros((outputs, inputs))
    D[range(outputs - inputs, outputs), range(inputs)] = 1.0
    E = random.normal(size=(states, disturbances)) / states**0.5
    return Channelled(
        A - 0.3 * np.eye(states),
        B,
        C + 0.02 * random.normal(size=(rules, outputs, states)),
        np.repeat(D[None], rules, axis=0),
        E + 0.02 * random.normal(size=(rules, states, disturbances)),
    )


def energy_gain_condition(
    plant: Channelled, relaxation: str = "wang-tanaka-griffin", *, level: float = 1e2
) -> Condition:
    """Pose the least gamma for which u = -sum_j h_j M_j Q^-1 x holds the gain from w to z.

    Theta_ij = [ He(A_i Q - B_i M_j)  E_i       (C_i Q - D_i M_j)' ]
               [ E_i'                 -gamma I  0                  ] < 0,  0 < Q <= level I,
               [ C_i Q - D_i M_j      0         -gamma I           ]

    one block of width n + q + p for every rule and every pair of rules.
    """
    A, B, C, D, E = plant
    (r, n, m), q, p = B.shape, E.shape[2], C.shape[1]
    Q, gamma = Unknown("Q", n, n, symmetric=True), Unknown("gamma", 1, 1)
    M = gain_unknown(r, m, n, relaxation)
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(B, "B_{i}", over="i")
    C_i, D_i = matrix(C, "C_{i}", over="i"), matrix(D, "D_{i}", over="i")
    M_j = M.over("j")
    theta = block(
        [
            [He(A_i @ Q - B_i @ M_j), matrix(E, "E_{i}", over="i"), None],
            [None, -gamma * identity(q), 0],
            [C_i @ Q - D_i @ M_j, 0, -gamma * identity(p)],
        ]
    )
    slack, sums = relaxation_named(relaxation)(double_sum_of(theta << 0, rules=r))
    return pose(
        positive_definite(Q),
        scale_bound(Q, level),
        *sums,
        minimise=gamma,
        unknowns=(Q, M, gamma, *slack),
        name="energy gain, compensation",
    )


def least_trace_condition(A: Floats) -> Condition:
    """Pose the least tr P with P >= I and A_i' P + P A_i <= 0 at every vertex, (N, n, n)."""
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    size = 2.0 * float(np.linalg.norm(A, axis=(1, 2)).max())
    return pose(
        (P >> np.eye(n)).named("floor of P"),
        (He(P @ matrix(A, "A_{i}")) << 0).named("vertex", weight=size),
        minimise=trace(P),
        name="common Lyapunov function of least trace",
    )
