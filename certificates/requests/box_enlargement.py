"""Requests the largest enlargement of the premises' ranges with one quadratic function.

If no function exists even for the given ranges, narrower ones are tried; the result is then called
a part of the box, not an enlargement.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from takagi.certificates.requests.loop.decimals import DIGITS, rounded_down, short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

BACK_OFF = (0.999, 0.99, 0.95, 0.9, 0.75, 0.5, 0.0)
# The limit if the vertices do not differ, so that nothing bounds theta.
LARGEST = 1e6


@dataclass(frozen=True, slots=True)
class BoxEnlargement:
    """The largest theta with decay at ``decay_rate`` alpha [1/s], for any weights of the gains."""

    decay_rate: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.decay_rate) and self.decay_rate >= 0):
            raise ModelError(
                f"decay_rate = {self.decay_rate!r} was given; a number >= 0 [1/s] is needed"
            )

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``box-enlargement``; theta is reduced until the claim is proved."""
        from takagi.lmi.analysis.box_enlargement import wide_box

        answer = wide_box(
            loop.model, gains=loop.gains, law="independent", decay_rate=self.decay_rate
        )
        solver = str(answer.solver.get("status", ""))
        P, theta = np.eye(loop.A.shape[1]), 0.0
        if answer.P is not None and answer.enlargement is not None:
            P, theta = np.asarray(answer.P), min(answer.enlargement, LARGEST)
        claims = [
            self._claim(loop.model.name or "the model", rounded_down(share * theta), P, digits)
            for share in BACK_OFF
            for digits in DIGITS
        ]
        return first_proved(loop, claims, solver)

    def _claim(
        self, model: str, theta: float, P: Floats, digits: int
    ) -> tuple[str, dict[str, Any]]:
        """Return a description of the attempt, and the claim."""
        what, name = "enlargement", f"box enlargement of {model}"
        if theta < 1:
            what, name = "ranges shrunk to", f"part of the box of {model}"
        return f"{what} {theta:.6g}, P to {digits} digits", {
            "name": name,
            "kind": "box-enlargement",
            "decay_rate": self.decay_rate,
            "enlargement": theta,
            "P": short(P, digits).tolist(),
        }
