"""Closed loops as vertices: one for each pair of rules."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import EigenvalueRegion, NormBounded, d_stability, robust_lyapunov
from takagi.lmi.analysis.actuator_rates import pair_means, pairs_of
from takagi.models import TSModel


@settings(derandomize=True, max_examples=25, deadline=None)
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
    np.testing.assert_allclose(np.tensordot(weight, pair_means(X), 1), x, atol=1e-12)


def test_a_mean_that_fails_is_not_said_to_exclude_the_loop() -> None:
    """G(h) = -1 + 3 h_1 h_2 <= -1/4, though (G_12 + G_21)/2 = 1/2: the no is about means."""
    model = TSModel([[[-1.0]], [[5.0]]], [[[1.0]], [[2.0]]])
    gains = [[[0.0]], [[3.0]]]
    small = NormBounded(D=[[1e-3]], E=[[1.0]])

    for answer in (
        d_stability(model, EigenvalueRegion.half_plane(0.0), gains=gains),
        robust_lyapunov(model, small, gains=gains),
    ):
        assert not answer.found
        assert "a mean that fails excludes nothing" in answer.diagnosis
    assert "mean" not in d_stability(model, EigenvalueRegion.half_plane(0.0)).diagnosis
