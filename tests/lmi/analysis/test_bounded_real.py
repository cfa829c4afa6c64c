"""The energy gain of one vertex by its Riccati equation: the Hamiltonian's norm, and the room."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi.analysis.disturbance import disturbance_channel, energy_gain_of
from takagi.lmi.analysis.disturbance.bounded_real import bounded_real, norm_seen
from tests.lmi.norms import hamiltonian_norm

LESS = 1e-6


@pytest.mark.parametrize("seed", range(12))
def test_the_norm_that_is_seen_is_that_of_the_hamiltonian(seed: int) -> None:
    """Modes that ring, damped by a hundredth at the least, and every third with a direct path."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(4, 4))
    A = A - (np.linalg.eigvals(A).real.max() + 10.0 ** rng.uniform(-2, 0)) * np.eye(4)
    B, C = rng.normal(size=(4, 2)), rng.normal(size=(3, 4))
    D = rng.normal(size=(3, 2)) * (seed % 3 == 0)

    norm = hamiltonian_norm(A, B, C, D)
    assert norm * (1 - LESS) < norm_seen(A, B, C, D) < norm * (1 + LESS)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-3])
@pytest.mark.parametrize("through", [0.0, 0.5])
@pytest.mark.parametrize("fast", [1.0, 1e4])
def test_P_shows_no_more_than_was_given(fast: float, through: float, tolerance: float) -> None:
    """Three states, one of which is fast."""
    A = np.array([[-0.1, 1.0, 0.0], [-1.0, -0.1, 1.0], [0.0, -0.3 * fast, -fast]])
    B, C = np.array([[0.0], [1.0], [0.0]]), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.2]])
    D = np.array([[through], [0.0]])
    norm = hamiltonian_norm(A, B, C, D)
    P = bounded_real(A, B, C, D, tolerance=tolerance)
    assert P is not None
    gamma = norm * (1 + tolerance)
    side = np.hstack([P @ B, C.T])
    whole = np.block(
        [
            [P @ A + A.T @ P, side],
            [side.T, np.block([[-gamma * np.eye(1), D.T], [D, -gamma * np.eye(2)]])],
        ]
    )

    assert norm < energy_gain_of(disturbance_channel(A, B, C, D), P) < gamma
    assert np.linalg.eigvalsh(whole)[-1] < 0


def test_an_unstable_vertex_has_none() -> None:
    one = np.eye(1)

    assert bounded_real(one, one, one, 0 * one, tolerance=1e-3) is None


def test_an_output_that_shows_nothing_has_none() -> None:
    """Its norm is zero: no thousandth of it is any room."""
    A = np.diag([-1.0, -2.0])

    assert bounded_real(A, np.eye(2), np.zeros((1, 2)), np.zeros((1, 2)), tolerance=1e-3) is None
