"""Common quadratic Lyapunov functions against exact thresholds of the literature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from takagi.lmi import EigenvalueRegion, common_lyapunov, d_stability, exact_solution
from takagi.lmi.analysis.decay_rate import rates_of
from takagi.lmi.analysis.gain_pairs import pairs_of
from takagi.models import TSModel
from tests.lmi.known_models import planar_pair


def test_planar_pair_has_a_common_p_exactly_between_its_limits() -> None:
    """Dayawansa and Martin (1999): a common P exists exactly for 3 - sqrt 8 < a < 3 + sqrt 8."""
    for limit, inward in ((3 + np.sqrt(8), -1), (3 - np.sqrt(8), 1)):
        inside = common_lyapunov(planar_pair(limit * (1 + 1e-3 * inward)))
        outside = common_lyapunov(planar_pair(limit * (1 - 1e-3 * inward)))

        assert inside.status == "candidate"
        assert inside.margin > 1e-5
        assert outside.status == "infeasible"
        assert outside.P is None


@pytest.mark.parametrize(
    "vertices",
    [
        [[[-101.0]], [[-1e-8]]],
        [[[-101.0, 0.0], [0.0, -1e-8]]],
        [[[-1.0, 5.0], [0.0, -1e-8]], [[-1e-8, 0.0], [3.0, -400.0]]],
    ],
)
def test_a_slow_mode_beside_fast_ones_leaves_a_function(vertices: ArrayLike) -> None:
    """The margin is 1e-10 of the fast mode and less: exact arithmetic decides, as for a proof."""
    A = np.array(vertices)
    found = common_lyapunov(A)
    P = found.P

    assert found.status == "candidate" and P is not None and found.condition is not None
    solution = exact_solution(found.condition, found.values)
    assert solution is not None and solution.holds
    assert common_lyapunov(-A[-1:]).status == "infeasible"
    beyond = common_lyapunov(A, decay_rate=1.01e-8)
    assert beyond.status != "candidate"


def test_an_unstable_vertex_is_no_false_proof() -> None:
    """A = I with P > 1e-9 I was accepted on a solver's status; here it is a no, with its reason."""
    answer = common_lyapunov(np.eye(2))

    assert answer.status == "infeasible"
    assert "vertex 1 of 1 alone" in answer.diagnosis
    Z = answer.multipliers["vertex"][0]
    assert np.linalg.eigvalsh(Z + Z)[0] > -1e-12


def test_a_no_carries_multipliers_that_show_it() -> None:
    """Z_i >= 0, not all zero, with sum A_i Z_i + Z_i A_i' >= 0 exclude every P."""
    answer = common_lyapunov(planar_pair(8.0))
    assert answer.condition is not None
    A = answer.condition.lmis[2].terms[0].right
    assert A is not None
    Z = answer.multipliers["vertex"]
    flow = (A @ Z).sum(axis=0)

    assert np.trace(Z.sum(axis=0)) > 1e-2
    assert np.linalg.eigvalsh(Z).min() >= -1e-12
    assert np.linalg.eigvalsh(flow + flow.T)[0] > -1e-7
    assert "vertex 1 of 2" in answer.diagnosis and "vertex 2 of 2" in answer.diagnosis


def test_many_vertices_are_all_looked_at() -> None:
    """Solved with few of 3000 vertices, P still holds at every one; one bad vertex is found."""
    rng = np.random.default_rng(1)
    A = rng.standard_normal((5, 5)) - 4 * np.eye(5) + 0.15 * rng.standard_normal((3000, 5, 5))
    answer = common_lyapunov(A)

    assert answer.P is not None and answer.condition is not None
    assert rates_of(A, answer.P).min() > 0
    assert answer.condition.lmis[2].count < 200

    two = np.concatenate([A[:, :2, :2], planar_pair(8.0)])
    no = common_lyapunov(two)
    assert no.status == "infeasible"
    assert "of 3002" in no.diagnosis


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_the_loop_is_a_blend_of_its_pairs(seed: int, r: int) -> None:
    """X(h) - Y(h) K(h), and X(h), with weights h_i^2 and 2 h_i h_j that sum to one."""
    rng = np.random.default_rng(seed)
    X, Y = rng.standard_normal((r, 2, 3)), rng.standard_normal((r, 2, 2))
    K = rng.standard_normal((r, 2, 3))
    h = rng.dirichlet(np.ones(r))
    i, j = np.triu_indices(r)
    weight = np.where(i == j, 1, 2) * h[i] * h[j]
    x, y, k = (np.tensordot(h, part, 1) for part in (X, Y, K))

    np.testing.assert_allclose(np.tensordot(weight, pairs_of(X, Y, K), 1), x - y @ k, atol=1e-12)


def test_a_mean_that_fails_is_not_said_to_exclude_the_loop() -> None:
    """G(h) = -1 + 3 h_1 h_2 <= -1/4, though (G_12 + G_21)/2 = 1/2: the no is about means."""
    model = TSModel([[[-1.0]], [[5.0]]], [[[1.0]], [[2.0]]])
    gains = [[[0.0]], [[3.0]]]
    answer = d_stability(model, EigenvalueRegion.half_plane(0.0), gains=gains)

    assert not answer.found
    assert "a mean that fails excludes nothing" in answer.diagnosis
    assert "mean" not in d_stability(model, EigenvalueRegion.half_plane(0.0)).diagnosis
