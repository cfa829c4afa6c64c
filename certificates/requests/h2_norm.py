"""Asks for a bound on the output's variance under white noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.requests.decimals import rounded_up, short
from takagi.certificates.requests.disturbed_loop import Output, disturbed_path, path_evidence
from takagi.certificates.requests.loop import Loop
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.errors import ModelError

__all__ = ["H2Norm"]

Floats = NDArray[np.float64]
BACK_OFF = (1e-4, 1e-3, 1e-2, 0.1, 1.0)
DIGITS = (6, 9, 12, 15)
# Where a norm is asked for: how much of what it leaves the first inequality takes.
SHARES = (0.5, 0.1, 0.9)


@dataclass(frozen=True, slots=True, eq=False)
class H2Norm:
    """The mean of E|y|^2 over time is at most norm^2 for unit white noise.

    Attributes
    ----------
    norm : None takes the least that is found, a little more.
    disturbance, output : the path, as in ``disturbed_loop``.
    """

    norm: float | None = None
    disturbance: str | None = None
    output: Output | None = None

    def __post_init__(self) -> None:
        if self.norm is not None and not (np.isfinite(self.norm) and self.norm > 0):
            raise ModelError(f"norm = {self.norm!r} was given; a positive number is needed")

    def attempt(self, loop: Loop) -> Attempt:
        """Return the claim ``h2-norm``."""
        from takagi.lmi import h2_norm

        evidence = path_evidence(loop, self.disturbance, self.output)
        path = disturbed_path(loop, evidence)
        answer = h2_norm(*path, sample_time=loop.sample_time)
        solver = str(answer.solver.get("status", ""))
        if answer.P is None or answer.gain is None:
            one = np.eye(path[0].shape[1])
            claim = _claim(evidence, self.norm or 1.0, one)
            return first_proved(loop, [(answer.diagnosis or "no bound was found", claim)], solver)
        _, B, _, D = path
        if self.norm is None:
            more: tuple[float, ...] = BACK_OFF
        else:
            left = (self.norm / answer.gain) ** 2 - 1
            more = tuple(share * max(left, 0.0) for share in SHARES)
        return first_proved(loop, self._claims(evidence, answer.P, B, D, more), solver)

    def _claims(
        self, evidence: dict[str, Any], P: Floats, B: Floats, D: Floats, more: tuple[float, ...]
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for share in more:
            for digits in DIGITS:
                rounded = short((1 + share) * P, digits)
                variance = np.einsum("ijk,jl,ilk->i", B, rounded, B) + (D**2).sum(axis=(1, 2))
                norm = self.norm or rounded_up(float(np.sqrt(variance.max())) * (1 + 1e-9))
                claim = _claim(evidence, norm, rounded)
                yield f"norm {norm:.6g} under white noise, P to {digits} digits", claim


def _claim(evidence: dict[str, Any], norm: float, P: Floats) -> dict[str, Any]:
    return {
        "name": "variance of the output under white noise",
        "kind": "h2-norm",
        **evidence,
        "norm": norm,
        "P": P.tolist(),
    }
