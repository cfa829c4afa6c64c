"""Asks how much wider the premises' ranges may be before one quadratic function serves no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.certificates.requests.decimals import DIGITS, rounded_down, short
from takagi.certificates.requests.loop import Loop
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.errors import ModelError

__all__ = ["BoxEnlargement"]

BACK_OFF = (0.999, 0.99, 0.95, 0.9, 0.75, 0.5, 0.0)
# Where nothing ends it: the vertices do not differ.
LARGEST = 1e6


@dataclass(frozen=True, slots=True)
class BoxEnlargement:
    """The largest theta with decay at ``decay_rate`` alpha [1/s]; the gains blend as they like."""

    decay_rate: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.decay_rate) and self.decay_rate >= 0):
            raise ModelError(
                f"decay_rate = {self.decay_rate!r} was given; a number >= 0 [1/s] is needed"
            )

    def attempt(self, loop: Loop) -> Attempt:
        """Return the claim ``box-enlargement``; theta is backed off until it proves."""
        from takagi.lmi.analysis.box_enlargement import wide_box

        answer = wide_box(
            loop.model, gains=loop.gains, law="independent", decay_rate=self.decay_rate
        )
        solver = str(answer.solver.get("status", ""))
        P, theta = np.eye(loop.A.shape[1]), 0.0
        if answer.P is not None and answer.enlargement is not None:
            P, theta = np.asarray(answer.P), min(answer.enlargement, LARGEST)
        claims = [
            (
                f"enlargement {rounded_down(share * theta):.6g}, P to {digits} digits",
                {
                    "name": f"box enlargement of {loop.model.name or 'the model'}",
                    "kind": "box-enlargement",
                    "decay_rate": self.decay_rate,
                    "enlargement": rounded_down(share * theta),
                    "P": short(P, digits).tolist(),
                },
            )
            for share in BACK_OFF
            for digits in DIGITS
        ]
        return first_proved(loop, claims, solver)
