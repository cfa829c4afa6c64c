"""Requests a bound on the output's variance under white noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from takagi.certificates.document.model_data import rounded_up, short
from takagi.certificates.requests.loop.disturbance_channel import (
    Output,
    Path,
    channel_evidence,
    disturbance_channel,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, first_proved, require_positive
from takagi.models.arrays import Floats

# P is searched this far (relative) above the least norm, so that the rounded P keeps a margin.
INSIDE, AT_LEAST = (1e-4, 4e-4), 5e-7
# Fractions added to P, and its digits; each is tried until the rounded numbers prove the claim.
BACK_OFF = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
DIGITS = (6, 9, 12, 15)
# The same for the P of a Lyapunov equation, which is accurate up to rounding.
SLIGHTLY = (0.0, 1e-5, 1e-4)
# For a requested norm: the part of the margin to it that the first inequality uses.
SHARES = (0.5, 0.1, 0.9)

NAME = "variance of the output under white noise"


@dataclass(frozen=True, slots=True, eq=False)
class H2Norm:
    """The mean of E|y|^2 over time is at most norm^2 for unit white noise.

    Attributes
    ----------
    norm : None takes slightly more than the least norm found.
    disturbance, output, entering : the channel, as in ``loop.disturbance_channel``.
    name : of the claim.
    """

    norm: float | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = NAME

    def __post_init__(self) -> None:
        require_positive(norm=self.norm)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``h2-norm``."""
        evidence = channel_evidence(loop, self.disturbance, self.output, self.entering)
        path = disturbance_channel(loop, evidence)
        functions = list(self._of_one_vertex(loop, path))
        if functions:
            words = "Lyapunov equation"
            attempt = first_proved(loop, self._of_each(evidence, path, functions, SLIGHTLY), words)
            if attempt.proved:
                return attempt
        return self._by_program(loop, evidence, path)

    def _of_one_vertex(self, loop: ClaimedLoop, path: Path) -> Iterator[tuple[Floats, float]]:
        """Yield P of one vertex by its Lyapunov equation, and the norm that P proves."""
        from takagi.lmi.analysis.disturbance.guessed_function import gramian_with_room

        A, B, C, D = path
        if len(A) > 1 or (loop.sample_time is None and D.any()):
            return
        # A requested norm may have little margin; P is then searched for the least norm.
        for tolerance in (*INSIDE, AT_LEAST) if self.norm else INSIDE:
            P = gramian_with_room(
                A[0], B[0], C[0], sample_time=loop.sample_time, tolerance=2 * tolerance
            )
            if P is not None:
                variance = float(np.sum(B[0] * (P @ B[0])) + (D[0] ** 2).sum())
                yield P, float(np.sqrt(variance))

    def _by_program(self, loop: ClaimedLoop, evidence: dict[str, Any], path: Path) -> Attempt:
        from takagi.lmi import h2_norm

        answers = [
            h2_norm(*path, sample_time=loop.sample_time, tolerance=tolerance)
            for tolerance in ((INSIDE[0], AT_LEAST) if self.norm else INSIDE[:1])
        ]
        solver = str(answers[0].solver.get("status", ""))
        functions = [(a.P, a.gain) for a in answers if a.P is not None and a.gain is not None]
        if not functions:
            bound = np.eye(path[0].shape[1])
            claim = _claim(self.name, evidence, self.norm or 1.0, bound)
            words = answers[0].diagnosis or "no bound was found"
            return first_proved(loop, [(words, claim)], solver)
        return first_proved(loop, self._of_each(evidence, path, functions, BACK_OFF), solver)

    def _of_each(
        self,
        evidence: dict[str, Any],
        path: Path,
        functions: list[tuple[Floats, float]],
        back_off: tuple[float, ...],
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        _, B, _, D = path
        for P, least_norm in functions:
            increases = back_off
            if self.norm is not None:
                margin = (self.norm / least_norm) ** 2 - 1
                increases = tuple(share * max(margin, 0.0) for share in SHARES)
            yield from self._claims(evidence, P, B, D, increases)

    def _claims(
        self,
        evidence: dict[str, Any],
        P: Floats,
        B: Floats,
        D: Floats,
        increases: tuple[float, ...],
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for increase in increases:
            for digits in DIGITS:
                rounded = short((1 + increase) * P, digits)
                variance = np.einsum("ijk,jl,ilk->i", B, rounded, B) + (D**2).sum(axis=(1, 2))
                norm = self.norm or rounded_up(float(np.sqrt(variance.max())) * (1 + 1e-9))
                claim = _claim(self.name, evidence, norm, rounded)
                yield f"norm {norm:.6g} under white noise, P to {digits} digits", claim


def _claim(name: str, evidence: dict[str, Any], norm: float, P: Floats) -> dict[str, Any]:
    return {
        "name": name,
        "kind": "h2-norm",
        **evidence,
        "norm": norm,
        "P": P.tolist(),
    }
