"""The loop whose stability is asked: a model, or a model with the gains of its rules."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.loop_pairs import gain_stack
from takagi.lmi.analysis.slow_modes import slow_vertex
from takagi.lmi.argument_checks import Vertices, input_stack, sample_time_of, vertex_stack
from takagi.lmi.condition.term import Array
from takagi.lmi.cone.balance import state_units
from takagi.lmi.polynomials.simplex_polynomials import Known, marginals
from takagi.lmi.varying.parameter_space import Space, space_of
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class VaryingLoop:
    """x' = A(h) x, or x' = (A(h) - B(h) K(h)) x where there are gains; x+ in discrete time.

    Attributes
    ----------
    A, B, K : (r, n, n), (r, n, m), (r, m, n); B and K are None without gains.
    space : of the memberships.
    sample_time : T in s; None for continuous time.
    """

    A: Array
    B: Array | None
    K: Array | None
    space: Space
    sample_time: float | None

    @property
    def matrix(self) -> Known:
        """Return the loop's matrix as a polynomial in h."""
        A = self.space.known(self.A)
        if self.B is None or self.K is None:
            return A
        return A - self.space.known(self.B) @ self.space.known(self.K)

    @property
    def corners(self) -> Array:
        """Return the loop's matrix at the rules, (r, n, n)."""
        return self.A if self.B is None or self.K is None else self.A - self.B @ self.K

    def units(self, scales: ArrayLike | None) -> Floats:
        """Return s, (n,): powers of two that balance the loop at its rules, or next to scales."""
        return state_units(self.corners.astype(np.float64), scales, step=self.sample_time)

    def scaled(self, s: Floats) -> VaryingLoop:
        """Return the loop in floating point, in states xhat = x / s."""
        A = self.A.astype(np.float64) * s / s[:, None]
        if self.B is None or self.K is None:
            return replace(self, A=A)
        B, K = self.B.astype(np.float64), self.K.astype(np.float64)
        return replace(self, A=A, B=B / s[:, None], K=K * s)

    def hopeless(self, alpha: float) -> str:
        """Return why no P(h) of any degree can be: a rule, or two in equal parts, too slow.

        Memberships may rest anywhere, so every blend has to decay by itself.  Empty when these do.
        """
        r, step = len(self.A), self.sample_time
        found = slow_vertex(self.corners.astype(np.float64), alpha, step=step)
        if found is not None:
            return self._said(f"rule {found[0] + 1} of {r}", found[1], alpha)
        i, j = np.triu_indices(r, 1)
        if not len(i):
            return ""
        h = (np.eye(r)[i] + np.eye(r)[j]) / 2
        matrix = self.matrix
        w = marginals(h, self.space.sizes, self.space.corners)
        blends = np.tensordot(matrix.basis.values(w), matrix.values.astype(np.float64), axes=1)
        found = slow_vertex(blends, alpha, step=step)
        if found is None:
            return ""
        a, b = int(i[found[0]]), int(j[found[0]])
        return self._said(f"the mean of rules {a + 1} and {b + 1} of {r}", found[1], alpha)

    def _said(self, which: str, eigenvalue: complex, alpha: float) -> str:
        size = "" if self.sample_time is None else f", of size {abs(eigenvalue):.6g},"
        return (
            f"{which} alone rules it out: its eigenvalue {eigenvalue:.6g}{size} does not decay "
            f"faster than {alpha:g} 1/s; stabilise it, lower the decay rate, or shrink the box"
        )


def varying_loop(
    model: Vertices, gains: ArrayLike | None = None, sample_time: float | None = None
) -> VaryingLoop:
    """Return the loop of a model, or of vertices (r, n, n); with gains its B is needed.

    Raises
    ------
    ModelError : shapes, entries that are not finite, gains without inputs, a sample time that is
        not positive or not the model's.
    """
    A = vertex_stack(model)
    step = sample_time_of(model, sample_time)
    space = space_of(model, len(A))
    if gains is None:
        return VaryingLoop(A, None, None, space, step)
    B = input_stack(model, A)
    return VaryingLoop(A, B, gain_stack(gains, *(len(A), B.shape[2], A.shape[1])), space, step)
