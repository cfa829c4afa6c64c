"""Invariant ellipsoids under bounded disturbances: against closed forms, and by trajectories."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import start_set, start_set_condition
from takagi.lmi.analysis.invariant_ellipsoid import (
    decay_rates,
    invariant_ellipsoid,
    invariant_ellipsoid_condition,
    largest_scale,
    slacks,
)
from takagi.models import Floats, ModelError


def oscillators() -> tuple[Floats, Floats]:
    A = np.array([[[0.0, 1.0], [-1.0, -1.0]], [[0.0, 1.0], [-1.3, -1.2]]])
    return A, np.array([[0.0, 0.1], [0.0, 0.12]])


@pytest.mark.parametrize(("rate", "bound"), [(0.2, 1.0), (0.5, 0.1), (0.7, 20.0)])
def test_one_state_reaches_the_exact_peak(rate: float, bound: float) -> None:
    """x' = -a x + d, |d| <= 1, stays in |x| <= 1/a and no less: the scale inside b is a b."""
    found = invariant_ellipsoid(
        np.array([[[-rate]]]),
        np.array([[1.0]]),
        np.zeros(1, dtype=np.intp),
        np.array([[1 / bound]]),
    )

    assert found.P is not None
    assert 0.98 * rate * bound <= found.scale <= (1 + 1e-6) * rate * bound
    assert found.P[0, 0] == pytest.approx(1 / bound**2, rel=1e-3)
    assert found.multipliers[0] == pytest.approx(rate, rel=0.1)


def test_the_candidate_satisfies_what_was_posed() -> None:
    A, d = oscillators()
    directions = np.array([[2.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    found = invariant_ellipsoid(A, d, np.array([0, 1]), directions)

    assert found.P is not None
    peaks = np.einsum("di,ij,dj->d", directions, np.linalg.inv(found.P), directions)
    assert peaks.max() <= 1 + 1e-6
    assert slacks(found.P, A, 0.99 * found.scale * d, found.multipliers).max() < 0


def test_decay_rates_of_known_matrices() -> None:
    """With P = I the rate is minus the largest eigenvalue of the symmetric part."""
    A = np.array([np.diag([-1.0, -3.0]), [[-2.0, 5.0], [-5.0, -2.0]], [[1.0, 0.0], [0.0, -1.0]]])

    assert decay_rates(np.eye(2), A) == pytest.approx([1.0, 2.0, -1.0])
    assert decay_rates(7 * np.eye(2), A) == pytest.approx([1.0, 2.0, -1.0])


def test_largest_scale_is_the_root_of_the_inequality() -> None:
    A, d = oscillators()
    P = np.array([[3.0, 1.0], [1.0, 3.0]])
    fixed = 0.1 * d

    scale, alpha = largest_scale(P, A, fixed, d)
    multipliers = np.full(2, alpha)
    assert slacks(P, A, fixed + 0.999 * scale * d, multipliers).max() < 0
    assert slacks(P, A, fixed + 1.001 * scale * d, multipliers).max() > 0
    assert largest_scale(P, A, fixed, d, limit=0.01)[0] == 0.01
    assert largest_scale(P, A, 1e3 * d, d)[0] == 0.0


@pytest.mark.slow
def test_no_multiplier_bears_more_than_the_one_found() -> None:
    """A scan of 20000 multipliers, by the inequality's eigenvalues, finds nothing larger."""
    A, d = oscillators()
    P = np.array([[3.0, 1.0], [1.0, 3.0]])
    fixed = 0.1 * d

    scale, _ = largest_scale(P, A, fixed, d)
    more = fixed + (1 + 1e-5) * scale * d
    for alpha in np.geomspace(5e-4, 0.8, 20000):
        assert slacks(P, A, more, np.full(2, alpha)).max() > 0


def test_an_unstable_vertex_has_no_ellipsoid() -> None:
    A = np.array([[[0.1, 0.0], [0.0, -1.0]], [[-1.0, 0.0], [0.0, -1.0]]])
    found = invariant_ellipsoid(A, np.ones((2, 2)), np.zeros(2, dtype=np.intp), np.eye(2))

    assert found.P is None and found.scale == 0.0
    assert found.diagnosis


@pytest.mark.parametrize(
    ("d", "alpha", "directions"),
    [
        (np.ones((3, 2)), np.ones(2), np.eye(2)),
        (np.ones((2, 2)), np.ones(3), np.eye(2)),
        (np.ones((2, 2)), np.ones(2), np.eye(3)),
        (np.ones((2, 2)), np.array([1.0, 0.0]), np.eye(2)),
    ],
)
def test_sizes_and_signs_are_checked(d: Floats, alpha: Floats, directions: Floats) -> None:
    with pytest.raises(ModelError):
        invariant_ellipsoid_condition(oscillators()[0], d, alpha, directions)


# x' = -2 x + 3 e, e' = -3 e with |x| <= 1, as of x' = x + u, u = -3 xhat, L = 4.
LOOP = np.array([[[-2.0, 3.0], [0.0, -3.0]]])
ROWS = np.array([[1.0, 0.0]])
BLIND, SEEING = np.array([[1.0], [1.0]]), np.array([[1.0], [0.0]])


def reach(P: np.ndarray, N: np.ndarray) -> float:
    return float(1 / np.sqrt(N.T @ P @ N)[0, 0])


def test_a_blind_start_reaches_almost_what_the_motion_allows() -> None:
    """x = 4 e^-2t - 3 e^-3t from x = e = 1: at most 4 (8/9)^2 - 3 (8/9)^3 = 1.0535."""
    found = start_set(LOOP, ROWS, BLIND)

    assert found.P is not None
    exact = 1 / (4 * (8 / 9) ** 2 - 3 * (8 / 9) ** 3)
    assert 0.98 * exact < reach(found.P, BLIND) <= exact
    PG = found.P @ LOOP[0]
    assert np.linalg.eigvalsh(PG + PG.T).max() < 0
    assert ROWS @ np.linalg.inv(found.P) @ ROWS.T <= 1 + 1e-6


def test_a_start_without_error_reaches_the_limit() -> None:
    found = start_set(LOOP, ROWS, SEEING)

    assert found.P is not None
    assert 0.99 < reach(found.P, SEEING) <= 1 + 1e-6


def test_the_rate_is_kept_and_costs_starts() -> None:
    slow, fast = (start_set(LOOP, ROWS, BLIND, decay_rate=rate) for rate in (0.0, 1.8))

    assert slow.P is not None and fast.P is not None
    assert reach(fast.P, BLIND) < reach(slow.P, BLIND)
    PG = fast.P @ LOOP[0]
    assert np.linalg.eigvalsh(PG + PG.T + 2 * 1.8 * fast.P).max() < 0
    assert start_set(LOOP, ROWS, BLIND, decay_rate=2.1).P is None


def test_discrete_time() -> None:
    """x+ = 0.5 x + 1.5 e, e+ = 0.5 e from x = e = 1: x = 2, so that 1/2 may start."""
    G = np.array([[[0.5, 1.5], [0.0, 0.5]]])
    found = start_set(G, ROWS, BLIND, sample_time=1.0)

    assert found.P is not None
    assert 0.9 * 0.5 < reach(found.P, BLIND) <= 0.5 + 1e-6
    assert np.linalg.eigvalsh(G[0].T @ found.P @ G[0] - found.P).max() < 0


def test_a_loop_that_grows_has_none() -> None:
    found = start_set(np.array([[[0.1]]]), np.array([[1.0]]), np.eye(1))

    assert found.P is None and found.diagnosis


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ModelError, match="no limit"):
        start_set(LOOP, np.zeros((0, 2)), BLIND)
    with pytest.raises(ModelError, match="are needed"):
        start_set_condition(LOOP, ROWS, np.eye(3))
