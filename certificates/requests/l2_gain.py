"""Requests a bound on the energy gain from disturbance to output."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.document.model_data import rounded_down, rounded_up, short
from takagi.certificates.requests.loop.disturbance_channel import (
    Output,
    Path,
    channel_evidence,
    disturbance_channel,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import largest_level
from takagi.certificates.requests.request import Attempt, first_proved, require_positive
from takagi.models.arrays import Floats

# P is searched this far (relative) above the least gain, so that the rounded P keeps a margin.
INSIDE, AT_LEAST = 2e-4, 1e-6
# The same for a single vertex, whose P comes from a Riccati equation, without a solver.
ROOM = (1e-4, 3e-4, 8e-4)
# Fractions added to the least gain found; each is tried until the rounded numbers prove the claim.
BACK_OFF = (1e-4, 1e-3, 1e-2, 0.1, 1.0)
DIGITS = (6, 9, 12, 15)

NAME = "energy gain from disturbance to output"


@dataclass(frozen=True, slots=True, eq=False)
class L2Gain:
    """|y|_2 <= gain |w|_2 from rest.

    Attributes
    ----------
    gain : in units of y over those of w; None takes slightly more than the least gain found.
    energy_bound : W; for |w|_2 <= W no state leaves the box. "largest" takes the largest W, or
        none if the model has no box.
    disturbance, output, entering : the channel, as in ``loop.disturbance_channel``.
    name : of the claim.
    """

    gain: float | None = None
    energy_bound: float | Literal["largest"] | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = NAME

    def __post_init__(self) -> None:
        require_positive(gain=self.gain)
        if not isinstance(self.energy_bound, str):
            require_positive(energy_bound=self.energy_bound)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``l2-gain``."""
        evidence = channel_evidence(loop, self.disturbance, self.output, self.entering)
        path = disturbance_channel(loop, evidence)
        functions = list(self._of_one_vertex(loop, path))
        if functions:
            claims = (
                claim
                for P, gain in functions
                for claim in self._claims(loop, evidence, P, [self.gain or gain])
            )
            attempt = first_proved(loop, claims, "Riccati equation")
            if attempt.proved:
                return attempt
        return self._by_program(loop, evidence, path)

    def _of_one_vertex(self, loop: ClaimedLoop, path: Path) -> Iterator[tuple[Floats, float]]:
        """Yield P of one vertex by its Riccati equation, and the gain that P should prove."""
        from takagi.lmi.analysis.disturbance.guessed_function import bounded_real, norm_seen

        if len(path[0]) > 1 or loop.sample_time is not None:
            return
        A, B, C, D = (stack[0] for stack in path)
        # Of a gain that is given, little may be left: then P is looked for at the least one.
        for tolerance in (*ROOM, AT_LEAST) if self.gain else ROOM:
            P = bounded_real(A, B, C, D, tolerance=tolerance)
            if P is not None:
                yield P, rounded_up(norm_seen(A, B, C, D) * (1 + tolerance))

    def _by_program(self, loop: ClaimedLoop, evidence: dict[str, Any], path: Path) -> Attempt:
        from takagi.lmi import hinf_norm

        A, B, C, D = path
        # Of a gain that is given, little may be left: then P is looked for at the least one.
        answers = [
            hinf_norm(A, B, C, D, sample_time=loop.sample_time, tolerance=tolerance)
            for tolerance in ((INSIDE, AT_LEAST) if self.gain else (INSIDE,))
        ]
        answer = answers[0]
        solver = str(answer.solver.get("status", ""))
        functions = [(a.P, a.gain) for a in answers if a.P is not None and a.gain is not None]
        if not functions:
            words = answer.diagnosis or "no bound was found"
            return first_proved(
                loop,
                [(words, _claim(self.name, evidence, self.gain or 1.0, np.eye(len(A[0]))))],
                solver,
            )
        claims = (
            claim
            for P, least_gain in functions
            for claim in self._claims(loop, evidence, P, self._gains(least_gain))
        )
        return first_proved(loop, claims, solver)

    def _gains(self, least_gain: float) -> list[float]:
        return [self.gain] if self.gain else [rounded_up(least_gain * (1 + s)) for s in BACK_OFF]

    def _claims(
        self, loop: ClaimedLoop, evidence: dict[str, Any], P: Floats, gains: list[float]
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for gain in gains:
            for digits in DIGITS:
                claim = _claim(self.name, evidence, gain, short(P, digits))
                words = f"energy gain {gain:.6g}, P to {digits} digits"
                bound = self._energy(loop, evidence, P, gain)
                yield words, claim if bound is None else claim | {"energy_bound": bound}

    def _energy(
        self, loop: ClaimedLoop, evidence: dict[str, Any], P: Floats, gain: float
    ) -> float | None:
        if self.energy_bound != "largest":
            return self.energy_bound
        if evidence["disturbance"] == "inputs" and bounded_inputs(loop.exact):
            return None
        level = largest_level(loop, P)
        return rounded_down(0.999 * np.sqrt(level / gain), 4) if np.isfinite(level) else None


def _claim(name: str, evidence: dict[str, Any], gain: float, P: Floats) -> dict[str, Any]:
    return {
        "name": name,
        "kind": "l2-gain",
        **evidence,
        "gain": gain,
        "P": P.tolist(),
    }
