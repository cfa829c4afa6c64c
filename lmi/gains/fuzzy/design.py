"""Gains with a Lyapunov function that depends on the memberships, as a value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, WithAnswer
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FuzzyDesign(WithAnswer):
    """u = -M(h) G(h)^-1 x with M(h) = sum_i h_i M_i and G(h) likewise, and V = x' P(h) x.

    Attributes
    ----------
    gains : (r, m, n) for u = -sum_i h_i K_i x, K_i = M_i G^-1; None where G changes with the rule
        (the law is then no blend of gains), and where there are none.
    numerators : M, (r, m, n); None unless found.
    slacks : G, (r, n, n), the same in every rule where it is common; None unless found.
    matrices : (r, n, n): P_i of P(h) = sum_i h_i P_i; in discrete time S_i of P(h) = S(h)^-1.
    discrete : whether time is.
    decay_rate : alpha in 1/s that was asked for and holds; the answer's own is what was found.
    margin : as in ``Answer``.
    relaxation : name of the double-sum relaxation.
    answer : how it was found; its condition is in balanced states and inputs.
    """

    gains: Floats | None = None
    numerators: Floats | None = None
    slacks: Floats | None = None
    matrices: Floats | None = None
    discrete: bool
    decay_rate: float
    margin: float
    relaxation: str
    answer: Answer

    def gain(self, h: ArrayLike) -> Floats:
        """Return K(h) of u = -K(h) x, (..., m, n), for memberships h, (..., r).

        Raises
        ------
        ModelError : there are none, or another number of memberships.
        """
        numerators, slacks, _ = self._require()
        M, G = self._blend(numerators, h), self._blend(slacks, h)
        found = np.linalg.solve(np.swapaxes(G, -1, -2), np.swapaxes(M, -1, -2))
        return np.asarray(np.swapaxes(found, -1, -2))

    def P(self, h: ArrayLike) -> Floats:
        """Return P(h) of V = x' P(h) x, (..., n, n), for memberships h, (..., r).

        Raises
        ------
        ModelError : there is none, or another number of memberships.
        """
        blend = self._blend(self._require()[2], h)
        return np.asarray(np.linalg.inv(blend)) if self.discrete else blend

    def _blend(self, stack: Floats, h: ArrayLike) -> Floats:
        weights = np.asarray(h, dtype=np.float64)
        if weights.shape[-1:] != (len(stack),):
            raise ModelError(
                f"h has shape {weights.shape}; (..., {len(stack)}) is needed, one membership for "
                "each rule"
            )
        return np.asarray(np.tensordot(weights, stack, axes=1))

    def _require(self) -> tuple[Floats, Floats, Floats]:
        if self.numerators is None or self.slacks is None or self.matrices is None:
            raise ModelError(f"no gains were found ({self.status}): {self.answer.diagnosis}")
        return self.numerators, self.slacks, self.matrices
