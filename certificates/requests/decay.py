"""Requests decay with one quadratic function: at a given rate, or at the largest rate found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.requests.loop.decimals import DIGITS, rounded_down, short
from takagi.certificates.requests.loop.float_filter import cannot_decrease
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.single_matrix import equation_function, modal_function
from takagi.certificates.requests.no_common_decay import no_common_decay
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

LARGEST = 1e38
# Fractions of the rate found, tried in order until the rounded numbers prove the claim.
BACK_OFF = (0.999, 0.99, 0.9, 0.5, 0.0)


@dataclass(frozen=True, slots=True)
class Decay:
    """V = x'Px decays as exp(-2 alpha t); ``decay_rate`` alpha [1/s], None takes what is found."""

    decay_rate: float | None = None

    def __post_init__(self) -> None:
        rate = self.decay_rate
        if rate is not None and not (np.isfinite(rate) and rate >= 0):
            raise ModelError(f"decay_rate = {rate!r} was given; a number >= 0 [1/s] is needed")

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``decay``; where no P is found, ``no-common-decay`` if it is proved."""
        answer = common_function(loop, self.decay_rate)
        solver = str(answer.solver.get("status", ""))
        if self.decay_rate is None:
            # A loop that reaches the equilibrium in one step has an infinite rate.
            found = min(answer.decay_rate or 0.0, 1e6)
            rates = [rounded_down(share * found) for share in BACK_OFF]
        else:
            rates = [self.decay_rate]
        functions = [] if answer.P is None else [np.asarray(answer.P)]
        if self.decay_rate is not None:
            functions += _of_one_blend(loop, self.decay_rate)
        # Larger numbers are not written to a certificate.
        functions = [P for P in functions if np.abs(P).max() < LARGEST]
        if not functions or (self.decay_rate is None and (answer.decay_rate or 0.0) <= 0):
            no = no_common_decay(loop, self.decay_rate or 0.0, answer)
            if self.decay_rate is None or no.checked.verdict is Verdict.DISPROVED:
                return no
            other = faster_function(loop, self.decay_rate)
            if other is None:
                return no
            attempt = first_proved(loop, _claims(loop, [other], rates), solver)
            return replace(attempt, tried=(*no.tried, "P of the fastest rate", *attempt.tried))
        A = loop.A

        def cannot_hold(claim: Mapping[str, Any]) -> bool:
            P = np.array(claim["P"])
            return cannot_decrease(A, P, claim["decay_rate"], loop.sample_time)

        claims = list(_claims(loop, functions, rates))
        attempt = first_proved(loop, claims, solver, cannot_hold=cannot_hold)
        if attempt.proved or answer.P is not None:
            return attempt
        no = no_common_decay(loop, self.decay_rate or 0.0, answer)
        return replace(no, tried=attempt.tried + no.tried)


def common_function(loop: ClaimedLoop, decay_rate: float | None = None) -> Answer:
    """Return the candidate P for a rate, or for the largest rate found."""
    from takagi.lmi import common_lyapunov
    from takagi.lmi.analysis.decay_rate import fast_decay

    if decay_rate is None:
        return fast_decay(loop.A, sample_time=loop.sample_time)
    return common_lyapunov(loop.A, decay_rate=decay_rate, sample_time=loop.sample_time)


def faster_function(loop: ClaimedLoop, rate: float) -> Floats | None:
    """Return the candidate P of the largest rate [1/s] found, if it exceeds ``rate``.

    If gains are far larger than the states they act on, the margin at one rate is lost in rounding,
    and the solver finds no P. The search for the fastest rate still succeeds.
    """
    answer = common_function(loop)
    return None if answer.P is None or not (answer.decay_rate or 0.0) > rate else answer.P


def _of_one_blend(loop: ClaimedLoop, rate: float) -> list[Floats]:
    """Return functions that show the rate of a single matrix up to its slowest eigenvalue."""
    if len(loop.A) > 1:
        return []
    G = loop.A[0]
    found = (modal_function(G), equation_function(G, rate, loop.sample_time))
    return [P for P in found if P is not None]


def _claims(
    loop: ClaimedLoop, functions: list[Floats], rates: list[float]
) -> Iterator[tuple[str, dict[str, Any]]]:
    for rate in rates:
        for P in functions:
            for digits in DIGITS:
                claim = {
                    "name": f"common quadratic decay of {loop.model.name or 'the model'}",
                    "kind": "decay",
                    "decay_rate": rate,
                    "P": short(P, digits).tolist(),
                }
                yield f"decay rate {rate:.9g} 1/s, P to {digits} digits", claim
