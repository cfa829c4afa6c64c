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

The H-infinity norm of a loop, and a frequency at which it is reached, by Hamiltonian matrices.

For gamma above the largest singular value of D, gamma is a singular value of
G(jw) = C (jw I - A)^-1 B + D exactly where jw is an eigenvalue of

    H = [ A + B R^-1 D' C               gamma B R^-1 B'        ]
        [ -C' (I + D R^-1 D') C / gamma -(A + B R^-1 D' C)'    ],     R = gamma^2 I - D' D.

The largest gain at a few frequencies is a lower bound.  The level is put a little above it; between
the imaginary eigenvalues of H the gain is larger, so the middles of these intervals raise the
bound, quadratically, until H has no such eigenvalue.  Near the singular values of D, where R is
hardly invertible, the same eigenvalues are those of the pencil of

    jw x = A x + B w,   jw p = -A' p - C' z,   gamma z = C x + D w,   gamma w = B' p + D' z.

Source: Boyd, Balakrishnan, Kabamba (1989), Math. Control Signals Systems 2; Bruinsma and Steinbuch
(1990), Systems & Control Letters 14.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, eigvals

from takagi.models.arrays import Floats, Indices

Complex: TypeAlias = NDArray[np.complexfloating[Any, Any]]

# The level is so far above the bound, relative; a bound that rises by less is the norm.
ABOVE = 1e-8
ROUNDS = 30
# Nearer to a singular value of D than this, relative, the pencil is taken.
PENCIL_DISTANCE = 1e-3
# Eigenvalues within this angle of the imaginary axis give candidate frequencies.  One too many
# costs an evaluation; one too few would be an error.
ANGLE = 1e-4


class Peak(NamedTuple):
    """The largest gain, and its frequency in rad/s (inf for the direct term)."""

    gain: float
    frequency: float


def largest_gain(A: Floats, B: Floats, C: Floats, D: Floats) -> Peak:
    """Return the H-infinity norm of x' = A x + B w, z = C x + D w; inf where A is not stable.

    ``A``, ``B``, ``C``, ``D`` : (n, n), (n, q), (p, n), (p, q).

    A ``Peak``, in floating point: a candidate, accurate to about 1e-8 where the gain has one
    peak that is wider than rounding.
    """
    poles = np.linalg.eigvals(A)
    if not poles.real.max() < 0:
        return Peak(np.inf, 0.0)
    direct = float(np.linalg.norm(D, 2))
    # The gain usually peaks near a pole: at its modulus, or at its imaginary part if lightly
    # damped.
    first = np.unique(np.concatenate([[0.0], np.abs(poles), np.abs(poles.imag)]))
    best = _highest((A, B, C, D), first)
    if direct > best.gain:
        best = Peak(direct, np.inf)
    if best.gain == 0.0:
        return best
    for _ in range(ROUNDS):
        # Twice the tolerance above the bound, so that the known peak itself is no crossing any
        # more.
        level = (1.0 + 2.0 * ABOVE) * best.gain
        crossings = _crossings((A, B, C, D), level)
        if not len(crossings):
            break
        middles = (crossings[1:] + crossings[:-1]) / 2.0
        peak = _highest((A, B, C, D), np.concatenate([crossings, middles]))
        if not peak.gain > (1.0 + ABOVE) * best.gain:
            break
        best = peak
    return best


def response(A: Floats, B: Floats, C: Floats, D: Floats, points: Complex) -> Complex:
    """Return C (s I - A)^-1 B + D at each point s, (k, p, q)."""
    shifted = points[:, None, None] * np.eye(len(A)) - A
    inside = np.linalg.solve(shifted, np.broadcast_to(B, (len(points), *B.shape)))
    return np.asarray(C @ inside + D)


def _highest(system: tuple[Floats, Floats, Floats, Floats], frequencies: Floats) -> Peak:
    gains = np.linalg.norm(response(*system, 1j * frequencies), 2, axis=(1, 2))
    k = int(np.argmax(gains))
    return Peak(float(gains[k]), float(frequencies[k]))


def _crossings(system: tuple[Floats, Floats, Floats, Floats], level: float) -> Floats:
    """Return frequencies >= 0, in order, where a singular value may be ``level``."""
    A, B, C, D = system
    direct = np.linalg.svd(D, compute_uv=False)
    if direct.size and np.abs(level - direct).min() < PENCIL_DISTANCE * level:
        values = _of_pencil(system, level)
    else:
        inverse = np.linalg.inv(level**2 * np.eye(B.shape[1]) - D.T @ D)
        inside = A + B @ inverse @ D.T @ C
        weight = C.T @ (C + D @ inverse @ D.T @ C) / level
        H = np.block([[inside, level * B @ inverse @ B.T], [-weight, -inside.T]])
        values = np.linalg.eigvals(H)
    on_axis = np.abs(values.real) <= ANGLE * np.abs(values)
    return np.unique(np.abs(values[on_axis].imag))


def _of_pencil(system: tuple[Floats, Floats, Floats, Floats], level: float) -> Complex:
    A, B, C, D = system
    n, q, p = len(A), B.shape[1], len(C)
    pencil = np.zeros((2 * n + p + q, 2 * n + p + q))
    x, adjoint, z, w = slice(0, n), slice(n, 2 * n), slice(2 * n, 2 * n + p), slice(2 * n + p, None)
    pencil[x, x], pencil[x, w] = A, B
    pencil[adjoint, adjoint], pencil[adjoint, z] = -A.T, -C.T
    pencil[z, x], pencil[z, w], pencil[z, z] = C, D, -level * np.eye(p)
    pencil[w, adjoint], pencil[w, z], pencil[w, w] = B.T, D.T, -level * np.eye(q)
    moving = np.diag(np.repeat([1.0, 0.0], [2 * n, p + q]))
    above, below = eigvals(pencil, moving, homogeneous_eigvals=True)
    # The pencil is singular in z and w, so it has infinite eigenvalues too; they are dropped.
    finite = np.abs(below) > 1e-12 * np.abs(above)
    return np.asarray(above[finite] / below[finite])


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
