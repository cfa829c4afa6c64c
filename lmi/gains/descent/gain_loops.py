r"""Loops that are affine in a gain F, u = F y, with the gradients of norm and slowest mode.

    A(F) = A + B2 F C2     B(F) = B1 + B2 F D21     C(F) = C1 + D12 F C2     D(F) = D11 + D12 F D21

Let s be the point of the imaginary axis (of the unit circle, in discrete time) where the largest
singular value sigma of G(s) is reached, with the unit vectors v, w of w' G v = sigma.  Where sigma
is simple and s the only such point,

    d sigma / d F_kl = Re(a_k b_l),   a = w' (C(F) Phi B2 + D12),   b = (C2 Phi B(F) + D21) v,

Phi = (s I - A(F))^-1.  Of a simple eigenvalue with the left and right vectors y, x,
d lambda / d F_kl = (y' B2)_k (C2 x)_l / (y' x).  With several systems the largest value counts.

Source: Apkarian and Noll (2006), IEEE Trans. Automatic Control 51(1), section III, for the norm;
Burke, Lewis, Overton (2003), Linear Algebra and its Applications 367, for the slowest mode.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from takagi.lmi.analysis.disturbance.loop_norm import Peak, largest_gain, response
from takagi.models.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GainLoops:
    """Systems i = 1 ... r with u = F_g(i) y, F zero off the pattern.

    Attributes
    ----------
    A, B1, B2 : (r, n, n), (r, n, q), (r, n, m).
    C1, D11, D12 : (r, p, n), (r, p, q), (r, p, m).
    C2, D21 : (r, k, n), (r, k, q).
    pattern : (m, k), True where F may differ from zero.
    group : (r,), the number of the F that each system uses.
    discrete : x+ in the place of x'.
    allowed : whether F (groups, m, k) may be used; the norm of another F counts as infinite.
    """

    A: Floats
    B1: Floats
    B2: Floats
    C1: Floats
    C2: Floats
    D11: Floats
    D12: Floats
    D21: Floats
    pattern: NDArray[np.bool_]
    group: Indices
    discrete: bool = False
    allowed: Callable[[Floats], bool] = field(default=lambda F: True)

    @property
    def count(self) -> int:
        """Return the number of free entries of all gains."""
        return (int(self.group.max()) + 1) * int(self.pattern.sum())

    def gains(self, entries: Floats) -> Floats:
        """Return F, (groups, m, k), from its free entries."""
        F = np.zeros((int(self.group.max()) + 1, *self.pattern.shape))
        F[:, self.pattern] = entries.reshape(len(F), -1)
        return F

    def entries(self, F: Floats) -> Floats:
        """Return the free entries of F, as one vector."""
        return np.asarray(F[:, self.pattern].reshape(-1))

    def closed(self, F: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return A, B, C, D of the closed loops."""
        vertex_gains = F[self.group]
        return (
            self.A + self.B2 @ vertex_gains @ self.C2,
            self.B1 + self.B2 @ vertex_gains @ self.D21,
            self.C1 + self.D12 @ vertex_gains @ self.C2,
            self.D11 + self.D12 @ vertex_gains @ self.D21,
        )

    def slowest(self, entries: Floats) -> tuple[float, Floats]:
        """Return the largest real part of the poles, or their largest modulus less 1; gradient."""
        F = self.gains(entries)
        if self._beyond(F):
            return np.inf, np.zeros_like(entries)
        worst, gradient = -np.inf, np.zeros_like(F)
        for i, A in enumerate(self.closed(F)[0]):
            values, left_vectors, right_vectors = eig(A, left=True, right=True)
            sizes = np.abs(values) - 1.0 if self.discrete else values.real
            k = int(np.argmax(sizes))
            if sizes[k] <= worst:
                continue
            worst = float(sizes[k])
            y, x = left_vectors[:, k].conj(), right_vectors[:, k]
            turn = values[k].conj() / (abs(values[k]) or 1.0) if self.discrete else 1.0
            between = y @ x
            slope = np.outer(y @ self.B2[i], self.C2[i] @ x)
            # Two poles that meet have no gradient; the line search passes them.
            slope = slope * (turn / between) if abs(between) > 1e-14 else np.zeros_like(slope)
            gradient = np.zeros_like(F)
            gradient[self.group[i]] = slope.real
        return worst, self.entries(gradient)

    def norm(self, entries: Floats) -> tuple[float, Floats]:
        """Return the logarithm of the largest norm, and its gradient; inf where not stable."""
        F = self.gains(entries)
        if self._beyond(F):
            return np.inf, np.zeros_like(entries)
        loops = self.closed(F)
        worst, at = Peak(0.0, 0.0), 0
        for i in range(len(self.A)):
            A, B, C, D = (matrix[i] for matrix in loops)
            peak = _discrete_gain(A, B, C, D) if self.discrete else largest_gain(A, B, C, D)
            if not np.isfinite(peak.gain):
                return np.inf, np.zeros_like(entries)
            if peak.gain >= worst.gain:
                worst, at = peak, i
        gradient = np.zeros_like(F)
        gradient[self.group[at]] = self._slope(at, loops, worst.frequency)
        # A least norm of zero is approached, never reached.
        size = max(worst.gain, 1e-300)
        return float(np.log(size)), self.entries(gradient) / size

    def _beyond(self, F: Floats) -> bool:
        return not (np.isfinite(F).all() and self.allowed(F))

    def _slope(
        self, i: int, loops: tuple[Floats, Floats, Floats, Floats], frequency: float
    ) -> Floats:
        A, B, C, D = (matrix[i] for matrix in loops)
        if np.isinf(frequency) and not self.discrete:
            # The direct term: Phi is 0.
            from_input, to_output, response_matrix = self.D12[i], self.D21[i], D
        else:
            s = _on_circle(frequency) if self.discrete else 1j * frequency
            point = np.array([s])
            response_matrix = response(A, B, C, D, point)[0]
            from_input = response(A, self.B2[i], C, self.D12[i], point)[0]
            to_output = response(A, B, self.C2[i], self.D21[i], point)[0]
        left_vectors, _, right_vectors = np.linalg.svd(response_matrix)
        a, b = left_vectors[:, 0].conj() @ from_input, to_output @ right_vectors[0].conj()
        return np.asarray(np.outer(a, b).real)


def _on_circle(frequency: float) -> complex:
    """Return z = (1 + s) / (1 - s) at s = jw."""
    return -1.0 + 0j if np.isinf(frequency) else (1 + 1j * frequency) / (1 - 1j * frequency)


def _discrete_gain(A: Floats, B: Floats, C: Floats, D: Floats) -> Peak:
    """Return the norm over the unit circle: that of the bilinear transform, z = (1 + s)/(1 - s)."""
    eye = np.eye(len(A))
    if not np.abs(np.linalg.eigvals(A)).max() < 1.0:
        return Peak(np.inf, 0.0)
    back = np.linalg.inv(A + eye)
    root = np.sqrt(2.0)
    return largest_gain(back @ (A - eye), root * back @ B, root * C @ back, D - C @ back @ B)
