"""Requests decay of an observer's error, and of the loop with feedback of its estimate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.observer import error_loops, joint_loops, secant_loops
from takagi.certificates.requests.loop.decimals import (
    DIGITS,
    as_read,
    rounded_down,
    short,
    stack_of,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

BACK_OFF = (0.999, 0.99, 0.9, 0.5, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ObserverError:
    """The error of an observer with gains L decays.

    Attributes
    ----------
    L : (r, n, p), or (n, p) for the same gain in all rules.
    decay_rate : alpha in 1/s; None takes slightly less than the largest rate found.
    secants : (s, n, n) of the part that is not measured: ``unmeasured`` of ``takagi.lmi.observer``.
    """

    L: ArrayLike
    decay_rate: float | None = None
    secants: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``observer``.

        Raises
        ------
        ModelError : a model without output, or with weights that an observer cannot evaluate; wrong
            shapes.
        """
        loop.refuse_averages("observer")
        evidence = _evidence(loop, self.L)
        if self.secants is not None:
            evidence["secants"] = np.atleast_3d(np.asarray(self.secants)).tolist()
        read = as_read(evidence)
        loops = secant_loops if self.secants is not None else error_loops
        A = stack_of(G for _, G in loops(read, loop.seen, "claim"))
        named = {"name": "error of the observer", "kind": "observer", **evidence}
        return _attempt(loop, A, named, self.decay_rate)


@dataclass(frozen=True, slots=True, eq=False)
class ObservedFeedback:
    """The loop with u = -sum_j h_j K_j xhat decays, xhat from an observer with gains L.

    Attributes
    ----------
    L, decay_rate : as in ``ObserverError``.
    """

    L: ArrayLike
    decay_rate: float | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``observed-feedback``.

        Raises
        ------
        ModelError : no gains; as ``ObserverError``.
        """
        loop.refuse_averages("observer")
        if loop.gains is None:
            raise ModelError("a loop with an observer has gains K as well; give them to certify")
        evidence = _evidence(loop, self.L)
        A = stack_of(G for _, G in joint_loops(as_read(evidence), loop.seen, "claim"))
        named = {"name": "loop with the observer", "kind": "observed-feedback", **evidence}
        return _attempt(loop, A, named, self.decay_rate)


def _evidence(loop: ClaimedLoop, given: ArrayLike) -> dict[str, Any]:
    L = np.asarray(given, dtype=np.float64)
    L = L[None] if L.ndim == 2 else L
    r, n = loop.model.A.shape[:2]
    p = loop.model.C.shape[1]
    if not p:
        raise ModelError(f"model {loop.model.name!r} has no output to observe from; give C")
    if L.shape not in ((r, n, p), (1, n, p)) or not np.isfinite(L).all():
        raise ModelError(f"L has shape {np.shape(given)}; ({r}, {n}, {p}) or ({n}, {p}) is needed")
    return {"L": (L[:1] if (L == L[0]).all() else L).tolist()}


def _attempt(loop: ClaimedLoop, A: Floats, named: dict[str, Any], rate: float | None) -> Attempt:
    from takagi.lmi import common_lyapunov
    from takagi.lmi.analysis.decay_rate import fast_decay

    if rate is None:
        answer = fast_decay(A, sample_time=loop.sample_time)
        rates = [rounded_down(s * min(answer.decay_rate or 0.0, 1e6)) for s in BACK_OFF]
    else:
        answer, rates = common_lyapunov(A, decay_rate=rate, sample_time=loop.sample_time), [rate]
    solver = str(answer.solver.get("status", ""))
    if answer.P is None or (rate is None and (answer.decay_rate or 0.0) <= 0):
        idle = named | {"decay_rate": rate or 0.0, "P": np.eye(A.shape[1]).tolist()}
        return first_proved(loop, [(answer.diagnosis or "no candidate P", idle)], solver)
    return first_proved(loop, _claims(named, np.asarray(answer.P), rates), solver)


def _claims(
    named: dict[str, Any], P: Floats, rates: list[float]
) -> Iterator[tuple[str, dict[str, Any]]]:
    for rate in rates:
        for digits in DIGITS:
            words = f"decay rate {rate:.6g} 1/s, P to {digits} digits"
            yield words, named | {"decay_rate": rate, "P": short(P, digits).tolist()}
