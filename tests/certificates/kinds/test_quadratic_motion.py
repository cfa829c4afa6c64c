"""The level that a disturbance holds V to, at its best multiplier: off the grid, at the edge."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.certificates.requests.loop.set_level import (
    best_multiplier,
    fall_rate,
    invariant_level,
)


@pytest.mark.parametrize("rate", [1.0, 1.1, 3.3])
def test_the_best_multiplier_of_two_vertices_is_found_between_grid_points(rate: float) -> None:
    """x' = -a x + b w at two vertices: b^2 / (s (2 a - s)) each, equal at the best s."""
    a, b = np.array([rate, 2.0 * rate]), np.array([1.0, 3.0])
    A, W, P = -a[:, None, None], b[:, None, None], np.eye(1)
    dense = np.linspace(1e-6, 2 * rate * (1 - 1e-6), 200_001)
    least = (b[:, None] ** 2 / (dense * (2 * a[:, None] - dense))).max(axis=0).min()

    level, multiplier = best_multiplier(A, W, P, discrete=False)

    assert least * (1 - 1e-5) <= level <= least * (1 + 1e-5)
    assert level == pytest.approx(invariant_level(A, W, P, multiplier, discrete=False))


def test_the_best_multiplier_may_lie_next_to_the_rate_of_fall() -> None:
    """x1 alone is disturbed and falls fast, x2 slowly: the level is least at the slow rate's end.

    A grid that ended at 98 per cent of it left one per cent of the level away.
    """
    A, W, P = np.diag([-5.0, -0.5])[None], np.array([[[1.0], [0.0]]]), np.eye(2)
    least = 1.0 / (1.0 * (10.0 - 1.0))

    level, multiplier = best_multiplier(A, W, P, discrete=False)
    known, _ = best_multiplier(A, W, P, discrete=False, start=1.0 - 1e-9)

    assert least < level < least * (1 + 1e-3) and multiplier < 1.0
    assert known == pytest.approx(least, rel=1e-8)


def test_a_p_that_rounding_made_indefinite_shows_nothing() -> None:
    """Ill-conditioned P to too few digits: no level, and no exception."""
    P = np.array([[1.0, 1.0], [1.0, 1.0 - 1e-9]])
    A, W = -np.eye(2)[None], np.ones((1, 2, 1))

    assert fall_rate(A, P, discrete=False) == -np.inf
    assert best_multiplier(A, W, P, discrete=False) == (np.inf, 0.0)
