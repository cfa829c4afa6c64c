"""Requests decay with a quadratic function that is scheduled by the weights."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.requests.fuzzy_pieces import cut
from takagi.certificates.requests.loop.decimals import DIGITS, rounded_down
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.weight_points import grid
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.certificates.requests.scheduled_function import scheduled_function
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer
    from takagi.lmi.polynomials.simplex_polynomials import PolynomialLyapunov

BACK_OFF = (1.0, 0.99, 0.9, 0.5, 0.0)
POLYA = (0, 1, 2, 4, 7)
# Blends whose weights are multiples of 1/4, at most this many; and how often the blends at which
# P(h) failed are added to them.
PARTS, MOST_POINTS, ROUNDS = 4, 81, 10


@dataclass(frozen=True, slots=True, eq=False)
class FuzzyDecay:
    """V = x'P(h)x decays as long as the weights change no faster than the given rates.

    Attributes
    ----------
    rate_bounds : of |dz_k/dt| for each premise, by name or in order, in its unit per second;
        without premises of |dh_i/dt| in 1/s.  One number holds for all; inf means no bound.  In
        discrete time the weights may jump, and this attribute is not used.
    decay_rate : alpha [1/s].
    degree : of P in the weights of each premise, or of the rules.
    """

    rate_bounds: ArrayLike | Mapping[str, float] = np.inf
    decay_rate: float = 0.0
    degree: int | Sequence[int] = 1

    def __post_init__(self) -> None:
        if not (np.isfinite(self.decay_rate) and self.decay_rate >= 0):
            raise ModelError(
                f"decay_rate = {self.decay_rate!r} was given; a number >= 0 [1/s] is needed"
            )

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``fuzzy-decay``; the rate is reduced until the claim is proved.

        If the coefficients of P(h) do not prove it, pieces of the weights are tried.

        If no candidate is found, the claim has a common P, and the checker answers UNDECIDED.

        Raises
        ------
        ModelError : a secant embedding, whose weights cannot be evaluated; a model without
            premises, which has no weights to schedule with.
        """
        loop.refuse_averages("function")
        if loop.exact.corners is not None and not loop.exact.corners[0]:
            raise ModelError(
                "FuzzyDecay was asked for, but the model has no premises, so that a function of "
                "the weights is a common one: ask for Decay"
            )
        from takagi.lmi import fuzzy_lyapunov

        for polya in POLYA:
            answer = fuzzy_lyapunov(
                loop.model,
                rate_bounds=np.inf if loop.sample_time is not None else self.rate_bounds,
                degree=self.degree,
                decay_rate=self.decay_rate,
                relaxation=f"polya-{polya}",
                gains=loop.gains,
            )
            if answer.found:
                break
        solver = str(answer.solver.get("status", ""))
        tried: tuple[str, ...] = (answer.diagnosis, "no P(h) was found")
        if answer.lyapunov_function is not None:
            attempt = first_proved(loop, list(self._claims(loop, answer, polya)), solver)
            if attempt.proved:
                return attempt
            tried = attempt.tried
        attempt = self._on_pieces(loop, tried)
        if attempt.proved or answer.lyapunov_function is None:
            return attempt
        return first_proved(loop, list(self._claims(loop, answer, polya)), solver)

    def _on_pieces(self, loop: ClaimedLoop, tried: tuple[str, ...]) -> Attempt:
        """Return the attempt with P(h) from single blends, on pieces of the weights.

        Not used if P may not depend on any weight: ``Decay`` covers this and has its own pieces.
        """
        from takagi.lmi.varying.membership_points import function_at_points

        idle = self._claim(loop, None, 0.0, DIGITS[0], 0)
        solver = ""
        points = grid(loop.exact, PARTS, MOST_POINTS)
        for _ in range(ROUNDS if points else 0):
            answer = function_at_points(
                loop.model,
                [[v / sum(row) for row in point for v in row] for point in points],
                rate_bounds=self.rate_bounds,
                degree=self.degree if isinstance(self.degree, int) else tuple(self.degree),
                decay_rate=self.decay_rate,
                gains=loop.gains,
            )
            solver = str(answer.solver.get("status", ""))
            if answer.lyapunov_function is None or not any(answer.lyapunov_function.basis.degrees):
                tried = (*tried, f"no P(h) at {len(points)} blends of the loop")
                break
            claim = self._claim(loop, answer.lyapunov_function, self.decay_rate, DIGITS[-1], 0)
            found = cut(claim, loop.exact)
            words = f"P(h) from {len(points)} blends of the loop"
            if found.halvings:
                claim["halvings"] = found.halvings
                words += f", on {found.halvings.count([])} pieces of the weights"
                return Attempt(claim, loop.replay(claim), (*tried, words), solver)
            tried = (*tried, words)
            fresh = [point for point in dict.fromkeys(found.failed) if point not in points]
            if not fresh:
                break
            points = [*points, *fresh]
        return Attempt(idle, loop.replay(idle), tried, solver)

    def _claims(
        self, loop: ClaimedLoop, answer: Answer, polya: int
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for share in BACK_OFF if self.decay_rate else BACK_OFF[:1]:
            rate = self.decay_rate if share == 1.0 else rounded_down(share * self.decay_rate)
            for digits in DIGITS[1:]:
                for raised in sorted({polya, polya + 1}):
                    words = f"decay rate {rate:.6g} 1/s, P(h) to {digits} digits, raised {raised}"
                    yield words, self._claim(loop, answer.lyapunov_function, rate, digits, raised)

    def _claim(
        self,
        loop: ClaimedLoop,
        function: PolynomialLyapunov | None,
        rate: float,
        digits: int,
        polya: int,
    ) -> dict[str, Any]:
        return {
            "name": f"decay of {loop.model.name or 'the model'} by a scheduled function",
            "kind": "fuzzy-decay",
            "decay_rate": rate,
            **scheduled_function(loop, function, self.rate_bounds, digits=digits, polya=polya),
        }
