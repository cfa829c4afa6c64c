"""Requests that the eigenvalues of every blend lie in a region of the complex plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.requests.loop.decimals import DIGITS, short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.single_matrix import modal_function
from takagi.certificates.requests.request import Attempt, first_proved

if TYPE_CHECKING:
    from takagi.lmi.condition.region import EigenvalueRegion


@dataclass(frozen=True, slots=True)
class Poles:
    """Eigenvalues of every blend in ``region``, a ``takagi.lmi.EigenvalueRegion``, in 1/s.

    In discrete time they are the eigenvalues of the matrix itself, without a unit: a stable loop
    has them inside the unit circle.  L and M are written as decimals, and the claim is about these.
    """

    region: EigenvalueRegion

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``region``; without a candidate the checker answers UNDECIDED.

        Raises
        ------
        ModelError : no region was given.
        """
        from takagi.lmi import d_stability

        answer = d_stability(loop.A, self.region, sample_time=loop.sample_time)
        solver = str(answer.solver.get("status", ""))
        parts = [
            {"L": np.asarray(L, dtype=float).tolist(), "M": np.asarray(M, dtype=float).tolist()}
            for L, M in (part.matrices for part in self.region.parts)
        ]
        functions = [] if answer.P is None else [np.asarray(answer.P)]
        modal = modal_function(loop.A[0]) if len(loop.A) == 1 else None
        functions += [] if modal is None else [modal]
        claims = [
            (
                f"poles in {self.region}, P to {digits} digits",
                {
                    "name": f"poles in {self.region}",
                    "kind": "region",
                    "parts": parts,
                    "P": short(P, digits).tolist(),
                },
            )
            for P in functions or [np.eye(loop.A.shape[1])]
            for digits in DIGITS
        ]
        found = first_proved(loop, claims, solver)
        if found.proved or answer.found:
            return found
        return replace(found, tried=(answer.diagnosis, *found.tried))
