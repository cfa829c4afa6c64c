"""Fuzzy Lyapunov functions in discrete time: from arbitrary steps of the memberships to none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import Answer, expressed, fuzzy_lyapunov, fuzzy_lyapunov_condition, latex
from takagi.lmi.condition.evaluate import margin
from tests.lmi.known_models import rolmip_pair

Floats = NDArray[np.float64]


def steepest_step(A: Floats, answer: Answer, bound: float) -> float:
    """Return the largest V(x+) / V(x) over h and h+ that are no farther apart than the bound."""
    family = answer.lyapunov_function
    assert family is not None
    rng = np.random.default_rng(0)
    r = len(A)
    h = np.concatenate([np.repeat(np.eye(r), 40, axis=0), rng.dirichlet(np.ones(r), 300)])
    other = np.concatenate([np.tile(np.eye(r), (40, 1)), rng.dirichlet(np.ones(r), 300)])
    far = np.abs(other - h).max(axis=1, keepdims=True)
    after = h + (other - h) * np.minimum(1.0, bound / np.maximum(far, 1e-12))
    M = np.tensordot(h, A, axes=1)
    L = np.linalg.cholesky(family.at(h))
    moved = M.transpose(0, 2, 1) @ family.at(after) @ M
    inside = np.linalg.solve(L, np.linalg.solve(L, moved).transpose(0, 2, 1))
    return float(np.linalg.eigvalsh(inside)[:, -1].max())


@pytest.mark.parametrize(
    ("bound", "options", "limit"),
    [
        (np.inf, {"degree": 0}, 0.92932),
        (np.inf, {"relaxation": "polya-1"}, 0.99359),
        (np.inf, {"form": "dilated"}, 0.97315),
        (0.5, {"relaxation": "polya-1"}, 1.09935),
        (0.1, {"relaxation": "polya-1"}, 1.13988),
        (0.1, {"form": "dilated"}, 1.21800),
        (0.0, {"relaxation": "polya-1"}, 1.14712),
    ],
)
def test_discrete_time_from_any_step_to_none(
    bound: float, options: Mapping[str, Any], limit: float
) -> None:
    """ROLMIP's vertices times k with |h(t+1) - h(t)| <= bound; limits recomputed by bisection.

    No step at all is the constant parameter (``test_polynomial_lyapunov``), any step is Daafouz
    and Bernussou's condition, degree 0 the common P.
    """
    pose = {"rate_bounds": bound, "sample_time": 1.0, **options}
    below = fuzzy_lyapunov(rolmip_pair(limit - 1e-3), **pose)

    assert below.found
    assert not fuzzy_lyapunov(rolmip_pair(limit + 1e-3), **pose).found
    assert steepest_step(rolmip_pair(limit - 1e-3), below, bound) <= 1


def test_any_step_agrees_with_daafouz_and_bernussou() -> None:
    """[P_i, A_i' P_l; ., P_l] > 0 for every i and l: four items, in cvxpy as by ourselves."""
    A = rolmip_pair(0.99)
    condition = fuzzy_lyapunov_condition(
        A, rate_bounds=np.inf, relaxation="polya-0", sample_time=1.0
    )
    decrease = condition.lmis[-1]
    said = expressed(condition)
    said.problem().solve(solver="CLARABEL")
    answer = fuzzy_lyapunov(
        A, rate_bounds=np.inf, relaxation="polya-0", sample_time=1.0, scales=[1, 1]
    )

    assert [decrease.label(k) for k in range(4)] == ["h1 h1+", "h1 h2+", "h2 h1+", "h2 h2+"]
    assert margin(condition, said.values()) == pytest.approx(answer.margin, rel=1e-4)
    assert r"P(h^+)" in latex(condition)


@pytest.mark.parametrize("form", ["direct", "dilated"])
def test_three_discrete_rules_with_bounded_steps(form: Any) -> None:
    """Steps of a third at most; V falls by what was asked along all of them, and T counts."""
    A = np.array([[[0.1, 0.9], [0.0, 0.1]], [[0.5, 0.0], [0.9, 0.5]], [[0.3, 0.3], [-0.6, 0.2]]])
    answer = fuzzy_lyapunov(
        A, rate_bounds=3.0, sample_time=0.1, relaxation="polya-0", decay_rate=0.2, form=form
    )
    assert answer.decay_rate is not None and answer.decay_rate >= 0.2

    assert steepest_step(A, answer, 0.3) <= np.exp(-2 * 0.1 * answer.decay_rate) * (1 + 1e-6)
