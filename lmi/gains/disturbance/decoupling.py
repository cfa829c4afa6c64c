r"""Gains that keep a disturbance from the output altogether, so that every norm is zero.

V is the largest subspace in which gains hold the state while it shows no output, for every rule:

    (A_i - B F_i) V in V,    (C_i - D12 F_i) V = 0,

of one rule without the modes in it that do not decay and that no input moves.  If every E_i lies in
V, a disturbance never reaches z.  In the states xhat of x = [V, eps W] xhat, W the complement, the
output is eps times what it is, and the loop has numbers of order one; so the LMIs show a norm that
is as small as eps.

Source: Basile and Marro (1969), J. Optimization Theory and Applications 3; Wonham (1985), Linear
Multivariable Control, 3rd edition, theorem 4.2 and section 5.6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.analysis.common_quadratic import lyapunov
from takagi.lmi.cone.balance import state_units
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.models.arrays import Floats

# Singular values below this share of the matrices' size are zero.
ZERO = 1e-10
# The size of a pole in discrete time, below which it decays at once.
DEAD = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Decoupling:
    """Gains F_i, (r, m, n), for u = -F_i x, and two parts of x' P x, (n, n), on V and across it.

    Attributes
    ----------
    leaving : (k, m), what inputs u move out of V or show in the output: ``leaving`` u.
    rate : in 1/s, of the slowest mode of the loop at the mean vertex.
    """

    gains: Floats
    inside: Floats
    across: Floats
    leaving: Floats
    rate: float

    def quadratic(self, share: float) -> Floats:
        """Return P in whose coordinates the output is ``share`` times as large."""
        return self.inside + self.across / share**2


def decoupling(plant: DisturbedPlant) -> Decoupling | None:
    """Return gains that hide the disturbance from the output; None where there are none.

    For B and D12 that are the same in every rule.  In floating point: the LMIs are the test.
    """
    if (plant.B != plant.B[0]).any() or (plant.D12 != plant.D12[0]).any() or plant.D11.any():
        return None
    s = state_units(plant.A, None, step=plant.sample_time)
    A, E, C = plant.A * s / s[:, None], plant.E / s[:, None], plant.C * s
    C, D = (matrix / (np.abs(C).max(initial=0.0) or 1.0) for matrix in (C, plant.D12[0]))
    tau = 1.0 / np.linalg.norm(np.vstack([plant.B[0] / s[:, None], D]), axis=0)
    B, D = plant.B[0] / s[:, None] * tau, D * tau
    V = _hidden(A, B, C, D, discrete=plant.sample_time is not None)
    W = _kernel(V.T)
    if np.linalg.norm(W.T @ E) > ZERO * np.linalg.norm(E):
        return None
    F, free = _holding(A, B, C, D, V)
    A_V = (V.T @ (A - B @ F) @ V).mean(axis=0)
    A_W = (W.T @ A @ W).mean(axis=0)
    regulators = [_regulated(a, b, plant) for a, b in ((A_V, V.T @ B @ free), (A_W, W.T @ B))]
    if regulators[0] is None or regulators[1] is None:
        return None
    (K_V, P_V, rate_V), (K_W, P_W, rate_W) = regulators[0], regulators[1]
    gains = F + free @ K_V @ V.T + K_W @ W.T
    return Decoupling(
        gains=tau[:, None] * gains / s,
        inside=V @ P_V @ V.T / s / s[:, None],
        across=W @ P_W @ W.T / s / s[:, None],
        leaving=np.vstack([W.T @ B, D]) / tau,
        rate=min(rate_V, rate_W),
    )


def _hidden(A: Floats, B: Floats, C: Floats, D: Floats, *, discrete: bool) -> Floats:
    """Return an orthonormal basis of V."""
    V = np.eye(A.shape[1])
    while V.shape[1]:
        W = _kernel(V.T)
        unseen = _kernel(np.vstack([W.T @ B, D]).T)
        leaving = [np.vstack([W.T @ a, c]) @ V for a, c in zip(A, C, strict=True)]
        inside = _kernel(np.vstack([unseen.T @ matrix for matrix in leaving]))
        if inside.shape[1] == V.shape[1]:
            break
        V = V @ inside
    if len(A) > 1 or not V.shape[1]:
        return V
    F, free = _holding(A, B, C, D, V)
    A_V, reach = V.T @ (A[0] - B @ F[0]) @ V, V.T @ B @ free
    values, left_vectors = np.linalg.eig(A_V.T)
    lasting = np.abs(values) >= 1 if discrete else values.real >= 0
    unmoved = np.linalg.norm(left_vectors.T @ reach, axis=1) <= ZERO
    w = left_vectors[:, lasting & unmoved]
    return np.asarray(V @ _kernel(np.hstack([w.real, w.imag]).T))


def _holding(A: Floats, B: Floats, C: Floats, D: Floats, V: Floats) -> tuple[Floats, Floats]:
    """Return F_i = G_i V' that hold the state in V, and the inputs that leave it there."""
    W = _kernel(V.T)
    reached = np.vstack([W.T @ B, D])
    G = [
        np.linalg.lstsq(reached, np.vstack([W.T @ a, c]) @ V, rcond=None)[0]
        for a, c in zip(A, C, strict=True)
    ]
    return np.array(G) @ V.T, _kernel(reached)


def _regulated(A: Floats, B: Floats, plant: DisturbedPlant) -> tuple[Floats, Floats, float] | None:
    """Return gains, the Lyapunov function of their loop, and its slowest rate; None if unstable."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    discrete = plant.sample_time is not None
    n, m = B.shape
    if not n:
        return np.zeros((m, 0)), np.zeros((0, 0)), np.inf
    eye = np.eye(n)
    K: Floats = np.zeros((m, n))
    try:
        if m:
            X = (solve_discrete_are if discrete else solve_continuous_are)(A, B, eye, np.eye(m))
            gain = np.linalg.solve(np.eye(m) + B.T @ X @ B, B.T @ X @ A) if discrete else B.T @ X
            K = np.asarray(gain, np.float64)
        loop = A - B @ K
        poles = np.linalg.eigvals(loop)
        if plant.sample_time is None:
            rate = float(-poles.real.max())
        else:
            rate = float(-np.log(max(np.abs(poles).max(), DEAD)) / plant.sample_time)
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = lyapunov(loop, eye, plant.sample_time) if rate > 0 else None
    return None if P is None else (K, P, rate)


def _kernel(M: Floats) -> Floats:
    """Return an orthonormal basis of M x = 0, (columns, dimension), to rounding."""
    if not M.size:
        return np.eye(M.shape[1])
    _, sizes, vectors = np.linalg.svd(M)
    return np.asarray(vectors[int((sizes > ZERO * max(1.0, sizes[0])).sum()) :].T)
