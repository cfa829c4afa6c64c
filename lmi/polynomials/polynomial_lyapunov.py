"""A Lyapunov matrix that changes with the memberships: a polynomial by its coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.polynomials.simplex_polynomials import Basis, marginals
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialLyapunov:
    """P(h) = sum_a B_a(w(h)) P_a for V = x' P(h) x.

    Attributes
    ----------
    basis : the Bernstein polynomials B_a, on one simplex for each premise, or on that of the
        memberships; see ``takagi.lmi.polynomials.simplex_polynomials``.
    members : (count, n, n), the coefficients P_a; where the degree is 1, P at the rules.
    corners : (r, K), the corner of each simplex that rule i takes.
    """

    basis: Basis
    members: Floats
    corners: Indices

    @property
    def vertices(self) -> Floats:
        """Return P at the rules, (r, n, n)."""
        return np.asarray(self.members[self.basis.corners(self.corners)])

    def at(self, h: ArrayLike) -> Floats:
        """Return P(h), (..., n, n), for memberships h of the rules, (..., r).

        Raises
        ------
        ModelError : another number of memberships.
        """
        weights = np.asarray(h, dtype=np.float64)
        if weights.shape[-1:] != (len(self.corners),):
            raise ModelError(
                f"h has shape {weights.shape}; (..., {len(self.corners)}) is needed, one "
                "membership for each rule"
            )
        w = marginals(weights, self.basis.sizes, self.corners)
        return np.asarray(np.tensordot(self.basis.values(w), self.members, axes=1))
