"""Weights of a simplex around points: convex in exact decimals, touching, small where known."""

from __future__ import annotations

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.reduction.exact_residual import row_sums_are_one
from takagi.models.reduction.simplex_hull import simplex_weights


def cube(d: int) -> np.ndarray:
    return np.array([[(k >> axis) & 1 for axis in range(d)] for k in range(2**d)], dtype=float)


@given(seed=st.integers(0, 10**6), d=st.integers(0, 5), extra=st.integers(0, 8))
def test_weights_are_convex_in_exact_decimals_and_reproduce_the_points(
    seed: int, d: int, extra: int
) -> None:
    points = np.random.default_rng(seed).normal(size=(d + 1 + extra, d))

    G = simplex_weights(points)

    assert row_sums_are_one(G)
    corners = np.linalg.pinv(G) @ points
    assert np.allclose(G @ corners, points, atol=1e-6 * (1 + np.abs(corners).max(initial=0)))
    assert np.allclose(G.min(axis=0), 0, atol=1e-9) or d == 0


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_simplex_around_the_cube_has_d_to_the_d_times_its_volume(d: int) -> None:
    """A corner of the unit cube, widened d times: volume d^d / d!."""
    G = simplex_weights(cube(d))
    corners = np.linalg.pinv(G) @ cube(d)

    volume = abs(np.linalg.det(corners[1:] - corners[0])) / factorial(d)

    assert volume == pytest.approx(d**d / factorial(d))


def test_row_sums_are_those_of_the_decimals() -> None:
    """0.1 + 0.2 + 0.7 is 1 in decimals; 0.3333333333333333 three times is not."""
    assert row_sums_are_one(np.array([[0.1, 0.2, 0.7]]))
    assert not row_sums_are_one(np.full((1, 3), 1 / 3))
    assert not row_sums_are_one(np.array([[1.5, -0.5]]))
    assert Fraction(1, 3) != Fraction("0.3333333333333333")


def test_flat_points_are_refused() -> None:
    with pytest.raises(ModelError, match="less than 2 dimensions"):
        simplex_weights(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))
