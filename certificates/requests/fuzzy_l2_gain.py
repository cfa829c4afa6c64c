"""Requests a bound on the energy gain by a quadratic function that is scheduled by the weights."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.document.model_data import DIGITS, rounded_up
from takagi.certificates.requests.fuzzy_decay import refuse_without_weights, scheduled_function
from takagi.certificates.requests.loop.disturbance_channel import Output, channel_evidence
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, first_proved, require_positive
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

# Relative margins above the least gain; they are tried until the rounded numbers prove the claim.
BACK_OFF = (1e-4, 1e-3, 1e-2, 0.1)
# Exponents of Polya's theorem that are tried, one after another.
POLYA = (0, 1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class FuzzyL2Gain:
    """|y|_2 <= gain |w|_2 from rest, by V = x'P(h)x, while the weights keep the given rates.

    Attributes
    ----------
    gain : in units of y over those of w; None takes slightly more than the least gain found.
    rate_bounds : as for ``FuzzyDecay``: of |dz_k/dt| for each premise, of |dh_i/dt| without
        premises; in discrete time the weights may jump, and this attribute is not used.
    degree : of P in the weights of each premise, or of the rules.
    disturbance, output : the channel, as for ``L2Gain``.
    """

    gain: float | None = None
    rate_bounds: ArrayLike | Mapping[str, float] = np.inf
    degree: int | Sequence[int] = 1
    disturbance: str | None = None
    output: Output | None = None

    def __post_init__(self) -> None:
        require_positive(gain=self.gain)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``fuzzy-l2-gain``; a common P, left open, where no P(h) was found.

        Raises
        ------
        ModelError : a secant embedding, whose weights cannot be evaluated; a model without
            premises to schedule with; rules whose output or input matrices make the closed loop
            no blend of vertices that P(h) is searched for.
        """
        refuse_without_weights(loop, "FuzzyL2Gain", "L2Gain")
        evidence = channel_evidence(loop, self.disturbance, self.output)
        tried: list[str] = []
        solver = ""
        for polya in POLYA:
            answer = self._searched(loop, evidence, polya)
            solver = str(answer.solver.get("status", ""))
            if answer.lyapunov_function is None or answer.gain is None:
                tried.append(answer.diagnosis or "no P(h) was found")
                continue
            attempt = first_proved(loop, self._claims(loop, evidence, answer, polya), solver)
            if attempt.proved:
                return attempt
            tried += attempt.tried
        idle = self._claim(loop, evidence, None, self.gain or 1.0, DIGITS[0], 0)
        return Attempt(idle, loop.replay(idle), tuple(tried), solver)

    def _searched(self, loop: ClaimedLoop, evidence: dict[str, Any], polya: int) -> Answer:
        """Return P(h) of the closed loop's channel, from the LMIs of ``robust_hinf_norm``."""
        from takagi.lmi.varying.robust_gain import robust_hinf_norm

        return robust_hinf_norm(
            loop.model,
            loop.gains,
            _channel(loop, evidence),
            degree=self.degree if isinstance(self.degree, int) else tuple(self.degree),
            polya=polya,
            rate_bounds=np.inf if loop.sample_time is not None else self.rate_bounds,
        )

    def _claims(
        self, loop: ClaimedLoop, evidence: dict[str, Any], answer: Answer, polya: int
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        assert answer.gain is not None  # asked before
        gains = [self.gain] if self.gain else [rounded_up(answer.gain * (1 + s)) for s in BACK_OFF]
        for gain in gains:
            for digits in DIGITS[1:]:
                words = f"energy gain {gain:.6g}, P(h) to {digits} digits, raised {polya}"
                yield words, self._claim(loop, evidence, answer, gain, digits, polya)

    def _claim(
        self,
        loop: ClaimedLoop,
        evidence: dict[str, Any],
        answer: Answer | None,
        gain: float,
        digits: int,
        polya: int,
    ) -> dict[str, Any]:
        function = None if answer is None else answer.lyapunov_function
        return {
            "name": "energy gain from disturbance to output, by a scheduled function",
            "kind": "fuzzy-l2-gain",
            **evidence,
            "gain": gain,
            **scheduled_function(loop, function, self.rate_bounds, digits=digits, polya=polya),
        }


def _channel(loop: ClaimedLoop, evidence: dict[str, Any]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return E, C, D and F of the rules, (r, ., .) each: y = C x + D u + F w, before the law."""
    model, r = loop.model, len(loop.model.A)
    inputs = evidence["disturbance"] == "inputs"
    entering = np.asarray(model.B if inputs else model.E, dtype=np.float64)
    output = evidence.get("output", {})
    C = output.get("C", model.C)
    C = np.asarray(C, dtype=np.float64)
    m = 0 if model.B is None else model.B.shape[2]
    p, q = C.shape[1], entering.shape[2]
    D = output.get("D") if output else model.D
    D = np.zeros((r, p, m)) if D is None else np.asarray(D, dtype=np.float64)
    F = output.get("F")
    F = np.zeros((r, p, q)) if F is None else np.asarray(F, dtype=np.float64)
    C, D, F = (np.broadcast_to(stack, (r, *stack.shape[1:])) for stack in (C, D, F))
    return entering, C, D, F + D if inputs else F
