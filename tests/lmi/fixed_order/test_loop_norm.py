"""The norm with its frequency, against bisection, a published system, and where peaks hide."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi.gains.descent.gain_loops import largest_gain, response
from tests.lmi.fixed_order.plants import plant
from tests.lmi.norms import hamiltonian_norm, third_order

Floats = NDArray[np.float64]


def random_loop(seed: int, direct: float) -> tuple[Floats, Floats, Floats, Floats]:
    """A stable loop whose slowest mode decays at 0.001 to 1 1/s."""
    rng = np.random.default_rng(seed)
    n, q, p = rng.integers(1, 7, 3)
    A = rng.standard_normal((n, n))
    slowest = np.linalg.eigvals(A).real.max() + 10.0 ** rng.uniform(-3, 0)
    return (
        A - slowest * np.eye(n),
        rng.standard_normal((n, q)),
        rng.standard_normal((p, n)),
        direct * rng.standard_normal((p, q)),
    )


@pytest.mark.parametrize("direct", [0.0, 1.0, 10.0])
@pytest.mark.parametrize("seed", range(6))
def test_bisection_finds_the_same_norm(seed: int, direct: float) -> None:
    loop = random_loop(seed, direct)

    peak = largest_gain(*loop)

    assert peak.gain == pytest.approx(hamiltonian_norm(*loop), rel=1e-6)
    if np.isfinite(peak.frequency):
        at = response(*loop, np.array([1j * peak.frequency]))[0]
        assert np.linalg.norm(at, 2) == pytest.approx(peak.gain, rel=1e-9)
    else:
        assert np.linalg.norm(loop[3], 2) == peak.gain


def test_matlab_has_this_norm() -> None:
    """python-control, sysnorm_test.py: 4.276759162964233 by MATLAB for this system."""
    A, B, C = third_order()

    assert largest_gain(A, B, C, np.zeros((2, 2))).gain == pytest.approx(4.276759162964233)


def test_a_resonance_between_poles_and_grid_is_found() -> None:
    """1 / (s^2 + 2 d s + 1) has the peak 1 / (2 d sqrt(1 - d^2)) at sqrt(1 - 2 d^2)."""
    d = 1e-4
    A = np.array([[0.0, 1.0], [-1.0, -2 * d]])

    peak = largest_gain(A, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))

    assert peak.gain == pytest.approx(1 / (2 * d * np.sqrt(1 - d**2)), rel=1e-7)
    assert peak.frequency == pytest.approx(np.sqrt(1 - 2 * d**2), rel=1e-6)


def test_a_peak_a_little_above_the_direct_term_is_found() -> None:
    """AC4's loop of F = 0.29 (-1, 0) has its least gain near that of the direct term.

    With the inverse of gamma^2 I - D' D alone the peak was lost, and 0.9064 found for 0.97.
    """
    system = plant("AC4")
    F = np.array([[-0.29, -0.075]])
    loop = (
        system.A + system.B2 @ F @ system.C2,
        system.B1 + system.B2 @ F @ system.D21,
        system.C1 + system.D12 @ F @ system.C2,
        system.D11 + system.D12 @ F @ system.D21,
    )
    seen = np.linalg.norm(response(*loop, 1j * np.logspace(-4, 4, 20001)), 2, axis=(1, 2)).max()

    assert np.linalg.norm(loop[3], 2) < seen <= largest_gain(*loop).gain <= seen * (1 + 1e-4)


def test_an_unstable_loop_has_no_norm() -> None:
    one = np.eye(1)

    assert largest_gain(0.1 * one, one, one, one).gain == np.inf
    assert largest_gain(0.0 * one, one, one, one).gain == np.inf
    assert largest_gain(-0.1 * one, one, one, 0.0 * one).gain == pytest.approx(10.0)
