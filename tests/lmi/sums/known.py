"""Double sums of known matrices, whose largest eigenvalue over the memberships can be sampled."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import (
    Condition,
    DoubleSum,
    Unknown,
    double_sum_of,
    matrix,
    optimise,
    relaxation_named,
)
from takagi.models import Floats


def random_theta(seed: int, rules: int, size: int) -> Floats:
    rng = np.random.default_rng(seed)
    theta = rng.standard_normal((rules, rules, size, size))
    theta = theta + theta.transpose(0, 1, 3, 2)
    theta[np.arange(rules), np.arange(rules)] -= 3 * np.eye(size)
    return theta


def known_sum(theta: Floats, **known: object) -> tuple[DoubleSum, Unknown]:
    """Return sum_ij h_i h_j (Theta_ij - s I), and s."""
    s = Unknown("s", 1, 1)
    size = theta.shape[2]
    less = matrix(theta, r"\Theta_{{i}{j}}", over="ij") - s * np.eye(size)
    return double_sum_of(less << 0, rules=len(theta), **known), s  # type: ignore[arg-type]


def bound(theta: Floats, relaxation: str, **known: object) -> float:
    """Return the relaxation's upper bound on sum_ij h_i h_j Theta_ij: the least s with it."""
    loop, s = known_sum(theta, **known)
    slack, posed = relaxation_named(relaxation)(loop)
    condition = Condition(
        name="least bound", unknowns=(s, *slack), lmis=posed, objective={"s": np.ones((1, 1, 1))}
    )
    outcome = optimise(condition)
    assert outcome.status == "candidate"
    return float(outcome.values["s"][0, 0, 0])


def largest(theta: Floats, h: Floats, m: Floats | None = None) -> float:
    """Return the largest eigenvalue of sum_ij h_i m_j Theta_ij over the rows of h and m."""
    blend = np.einsum("ti,tj,ijab->tab", h, h if m is None else m, theta)
    return float(np.linalg.eigvalsh(blend)[:, -1].max())


def memberships(seed: int, rules: int, count: int = 4000) -> Floats:
    rng = np.random.default_rng(seed)
    inside = rng.dirichlet(np.ones(rules), count // 2)
    edges = rng.dirichlet(0.2 * np.ones(rules), count - count // 2 - rules)
    return np.concatenate([inside, edges, np.eye(rules)])


def combinations_of(*sides: int) -> NDArray[np.intp]:
    return np.array(list(product(*map(range, sides))), dtype=np.intp)


def product_memberships(corners: NDArray[np.intp], weights: list[Floats]) -> Floats:
    found = np.ones((len(weights[0]), len(corners)))
    for column, weight in enumerate(weights):
        found = found * weight[:, corners[:, column]]
    return found
