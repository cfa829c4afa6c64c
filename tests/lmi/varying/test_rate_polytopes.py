"""The corners of velocities and steps against linear programs over the same constraints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from takagi.lmi.varying.parameter_motion import step_corners, velocity_corners
from takagi.models import Floats, ModelError

BOUNDS = [[1, 1], [1, 2, 3], [0.1, 0.5, 2], [1, 1, 1, 1], [0, 0.2, 0.3], [0, 0, 2], [np.inf, 1, 1]]


def farthest(c: Floats, **constraints: Any) -> float:
    """Return the largest c . x under the constraints."""
    best = linprog(-c, **constraints)
    assert best.status == 0
    return -float(best.fun or 0.0)


@pytest.mark.parametrize("bound", BOUNDS)
def test_velocities_reach_as_far_as_the_bounds_let_them(bound: list[float]) -> None:
    """In every direction the farthest corner is the linear program's optimum, and none beyond."""
    phi = np.array(bound, dtype=np.float64)
    corners = velocity_corners(phi)
    for c in np.random.default_rng(0).standard_normal((20, len(phi))):
        far = farthest(c, A_eq=np.ones((1, len(phi))), b_eq=[0], bounds=np.stack([-phi, phi], 1))
        assert (corners @ c).max() == pytest.approx(far, abs=1e-9)
    assert np.abs(corners.sum(axis=1)).max() < 1e-12


@pytest.mark.parametrize("bound", [[0.3, 0.3], [0.3, 5], [0.3, 0.3, 0.3], [0.1, 0.5, 2], [0.3] * 4])
def test_steps_reach_as_far_as_the_bounds_let_them(bound: list[float]) -> None:
    phi = np.array(bound)
    n = len(phi)
    corners = np.concatenate(step_corners(phi)).T
    apart = np.hstack([-np.eye(n), np.eye(n)])
    sums = np.kron(np.eye(2), np.ones((1, n)))
    for c in np.random.default_rng(0).standard_normal((20, 2 * n)):
        far = farthest(
            c,
            A_ub=np.vstack([apart, -apart]),
            b_ub=np.concatenate([phi, phi]),
            A_eq=sums,
            b_eq=[1, 1],
        )
        assert (corners @ c).max() == pytest.approx(far, abs=1e-9)


def test_constant_memberships_have_one_velocity_and_step_to_themselves() -> None:
    assert velocity_corners(np.zeros(4)).tolist() == [[0.0] * 4]
    now, then = step_corners(np.zeros(3))
    np.testing.assert_array_equal(now, np.eye(3))
    np.testing.assert_array_equal(then, np.eye(3))


def test_too_many_are_refused_with_a_way_out() -> None:
    """The corners multiply with the memberships; the message says what to do instead."""
    with pytest.raises(ModelError, match="13 memberships .* more than 12; give the model"):
        velocity_corners(np.ones(13))
    with pytest.raises(ModelError, match="5 memberships .* more than 4; let"):
        step_corners(np.full(5, 0.1))
