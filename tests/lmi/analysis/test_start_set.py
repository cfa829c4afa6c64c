"""The set of starts of a given loop: a loop by hand, both kinds of time, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import start_set, start_set_condition
from takagi.models import ModelError

# x' = -2 x + 3 e, e' = -3 e with |x| <= 1, as of x' = x + u, u = -3 xhat, L = 4.
LOOP = np.array([[[-2.0, 3.0], [0.0, -3.0]]])
ROWS = np.array([[1.0, 0.0]])
BLIND, SEEING = np.array([[1.0], [1.0]]), np.array([[1.0], [0.0]])


def reach(P: np.ndarray, N: np.ndarray) -> float:
    """Return how far x may start."""
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
