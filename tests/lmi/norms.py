"""Norms by ways that are not under test: Hamiltonian, Gramians, frequencies; a known system."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from takagi.models import Floats


def third_order() -> tuple[Floats, Floats, Floats]:
    """A 2 x 2 system whose norms were computed in MATLAB: python-control, sysnorm_test.py (G4)."""
    A = np.array(
        [
            [-1.017041847539126, -0.224182952826418, 0.042538079149249],
            [-0.310374015319095, -0.516461581407780, -0.119195790221750],
            [-1.452723568727942, 1.7995860837102088, -1.491935830615152],
        ]
    )
    B = np.array(
        [
            [0.312858596637428, -0.164879019209038],
            [-0.864879917324456, 0.627707287528727],
            [-0.030051296196269, 1.093265669039484],
        ]
    )
    C = np.array(
        [
            [1.109273297614398, 0.077359091130425, -1.113500741486764],
            [-0.863652821988714, -1.214117043615409, -0.006849328103348],
        ]
    )
    return A, B, C


def hamiltonian_norm(A: Floats, B: Floats, C: Floats, D: Floats) -> float:
    """Return the H-infinity norm by bisection: is an eigenvalue of the Hamiltonian imaginary?

    Boyd, Balakrishnan and Kabamba (1989), Math. Control Signals Systems 2.
    """
    low = float(np.linalg.norm(D, 2))
    high = low + float(2 * np.linalg.norm(B, 2) * np.linalg.norm(C, 2))
    while not _above(A, B, C, D, high):
        low, high = high, 2 * high
    while high - low > 1e-9 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if _above(A, B, C, D, middle) else (middle, high)
    return high


def _above(A: Floats, B: Floats, C: Floats, D: Floats, gamma: float) -> bool:
    gap = gamma**2 * np.eye(B.shape[1]) - D.T @ D
    if np.linalg.eigvalsh(gap)[0] <= 0:
        return False
    inverse = np.linalg.inv(gap)
    inside = A + B @ inverse @ D.T @ C
    weight = C.T @ (np.eye(len(C)) + D @ inverse @ D.T) @ C
    H = np.block([[inside, B @ inverse @ B.T], [-weight, -inside.T]])
    eigenvalues = np.linalg.eigvals(H)
    return bool(np.abs(eigenvalues.real).min() > 1e-9 * np.abs(eigenvalues).max())


def frequency_norm(A: Floats, B: Floats, C: Floats, D: Floats, points: int = 4001) -> float:
    """Return the largest singular value of C (z - A)^-1 B + D over points of the unit circle."""
    z = np.exp(1j * np.linspace(0.0, np.pi, points))[:, None, None]
    response = C @ np.linalg.solve(z * np.eye(len(A)) - A, B[None]) + D
    return float(np.linalg.norm(response, 2, axis=(1, 2)).max())


def gramian_norm(A: Floats, B: Floats, C: Floats) -> float:
    gramian = solve_continuous_lyapunov(A, -B @ B.T)
    return float(np.sqrt(np.trace(C @ gramian @ C.T)))


def sampled_gramian_norm(A: Floats, B: Floats, C: Floats, D: Floats) -> float:
    gramian = solve_discrete_lyapunov(A, B @ B.T)
    return float(np.sqrt(np.trace(C @ gramian @ C.T) + np.trace(D @ D.T)))


def sampled(A: Floats, B: Floats, step: float) -> tuple[Floats, Floats]:
    """Return A and B of x' = A x + B w sampled, w held in between: a matrix exponential."""
    from scipy.linalg import expm

    n, m = B.shape
    M = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * step)
    return M[:n, :n], M[:n, n:]
