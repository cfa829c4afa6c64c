r"""The H-infinity norm of a loop, and a frequency at which it is reached, by Hamiltonian matrices.

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

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigvals

from takagi.models.arrays import Complex, Floats

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
    gains = np.linalg.norm(
        response(*system, np.asarray(1j * frequencies, np.complex128)), 2, axis=(1, 2)
    )
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
