"""Requests decay of an observer's error, of the loop with its estimate, and of a law of outputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.observed_loop import ranges_kept, starts, whole_loops
from takagi.certificates.checker.kinds.observer import error_loops, joint_loops, secant_loops
from takagi.certificates.document.model_data import (
    DIGITS,
    as_read,
    floats,
    rounded_down,
    short,
    stack_of,
)
from takagi.certificates.requests.decay import (
    BACK_OFF,
    decay_claims,
    function_along,
    rates_to_claim,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import SPARE
from takagi.certificates.requests.request import Attempt, Request, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False)
class ObserverError(Request):
    """The error of an observer with gains L decays.

    Attributes
    ----------
    L : (r, n, p), or (n, p) for the same gain in all rules.
    decay_rate : alpha in 1/s; None takes slightly less than the largest rate found.
    secants : (s, n, n) of the part that is not measured.
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
        A = stack_of(G for _, G in loops(read, loop.searched, "claim"))
        named = {"name": "error of the observer", "kind": "observer", **evidence}
        return _attempt(loop, A, named, self.decay_rate)


@dataclass(frozen=True, slots=True, eq=False)
class ObservedFeedback(Request):
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
        A = stack_of(G for _, G in joint_loops(as_read(evidence), loop.searched, "claim"))
        named = {"name": "loop with the observer", "kind": "observed-feedback", **evidence}
        return _attempt(loop, A, named, self.decay_rate)


def _evidence(loop: ClaimedLoop, gains: ArrayLike) -> dict[str, Any]:
    L = np.asarray(gains, dtype=np.float64)
    L = L[None] if L.ndim == 2 else L
    r, n = loop.model.A.shape[:2]
    p = loop.model.C.shape[1]
    if not p:
        raise ModelError(f"model {loop.model.name!r} has no output to observe from; give C")
    if L.shape not in ((r, n, p), (1, n, p)) or not np.isfinite(L).all():
        raise ModelError(f"L has shape {np.shape(gains)}; ({r}, {n}, {p}) or ({n}, {p}) is needed")
    return {"L": (L[:1] if (L == L[0]).all() else L).tolist()}


def _attempt(loop: ClaimedLoop, A: Floats, named: dict[str, Any], rate: float | None) -> Attempt:
    answer = function_along(A, rate, loop.sample_time)
    solver = str(answer.solver.get("status", ""))
    if answer.P is None or (rate is None and (answer.decay_rate or 0.0) <= 0):
        idle = named | {"decay_rate": rate or 0.0, "P": np.eye(A.shape[1]).tolist()}
        return first_proved(loop, [(answer.diagnosis or "no candidate P", idle)], solver)
    claims = decay_claims(named, [np.asarray(answer.P)], rates_to_claim(answer, rate))
    return first_proved(loop, claims, solver)


# The set is searched at this share of the largest rate: at the largest rate it would be small.
SHARE_OF_RATE, FASTEST = 0.25, 1e6


@dataclass(frozen=True, slots=True, eq=False)
class ObservedLoop(Request):
    """Plant and observer stay in {z'Pz <= c}, and V decays; the largest set of starts is searched.

    The observer is a part of the gains (``gains.observer`` of the certificate's law).

    Attributes
    ----------
    decay_rate : required alpha in 1/s; None searches a set at a quarter of the largest rate, and
        claims the rate of the function that is found.
    input_limits : (m,) largest |u_k - u_k*| on the set, besides the ranges of the box; None for
        none.
    P : (2n, 2n), a known function; None searches one.
    """

    decay_rate: float | None = None
    input_limits: ArrayLike | None = None
    P: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``observed-loop``.

        Raises
        ------
        ModelError : gains without an observer, no range that bounds the set, wrong limits.
        """
        limits = self._limits(loop)
        G, rows = loops_and_limits(loop, limits)
        if self.P is None:
            P, why, solver = _candidate(loop, G, rows, self.decay_rate)
        else:
            P, why, solver = np.asarray(self.P, dtype=np.float64), "given", "given"
        kind = {"name": "loop with the observer", "kind": "observed-loop", **limits}
        if P is None:
            idle = {"P": np.eye(G.shape[1]).tolist(), "level": 1.0}
            return first_proved(loop, [(why, kind | idle | {"decay_rate": self.decay_rate or 0.0})])
        return first_proved(loop, _claims(loop, kind, G, rows, P, self.decay_rate), solver)

    def _limits(self, loop: ClaimedLoop) -> dict[str, Any]:
        if loop.exact.observer is None:
            raise ModelError(
                "a loop with an observer needs gains.observer; give certify such a law"
            )
        if self.input_limits is None:
            return {}
        input_limits = np.asarray(self.input_limits, dtype=np.float64)
        m = loop.model.B.shape[2]
        if input_limits.shape != (m,) or not (input_limits > 0).all():
            raise ModelError(f"input_limits: {m} positive numbers are needed, not {input_limits}")
        return {"input_limits": input_limits.tolist()}


def loops_and_limits(loop: ClaimedLoop, limits: dict[str, Any]) -> tuple[Floats, Floats]:
    """Return G (N, 2n, 2n) of z' = G z, and rows r (T, 2n) with |r z| <= 1 inside the limits."""
    read = as_read(limits)
    G = stack_of(matrix for _, matrix in whole_loops(read, loop.exact, "claim"))
    rows = [
        floats(row)[0] / max(float(half), 1e-300)
        for row, half, _ in ranges_kept(read, loop.exact, "claim")
    ]
    return G, np.array(rows).reshape(-1, G.shape[1])


def starts_of(loop: ClaimedLoop) -> Floats:
    """Return N (2n, n) of z = N x: the estimate starts at the measured states, else at rest."""
    return floats(starts(loop.exact))


def _candidate(
    loop: ClaimedLoop, G: Floats, rows: Floats, rate: float | None
) -> tuple[Floats | None, str, str]:
    """Return P of {z'Pz <= 1} or None, the reason if None, and the solver's status."""
    from takagi.lmi.analysis.start_set import start_set

    if not len(rows):
        raise ModelError(
            f"model {loop.model.name!r} has no box of states, so nothing limits the set; give the "
            "states ranges"
        )
    if rate is None:
        answer = function_along(G, None, loop.sample_time)
        if answer.P is None or not (answer.decay_rate or 0.0) > 0:
            return None, answer.diagnosis or "no function decays", answer.status
        rate = SHARE_OF_RATE * min(answer.decay_rate or 0.0, FASTEST)
    answer_ = start_set(
        G, rows, starts_of(loop), decay_rate=1.0001 * rate, sample_time=loop.sample_time
    )
    return answer_.P, answer_.diagnosis, answer_.words


def _claims(
    loop: ClaimedLoop,
    kind: dict[str, Any],
    G: Floats,
    rows: Floats,
    P: Floats,
    decay_rate: float | None,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield claims with their words, the strongest first."""
    shares = BACK_OFF if decay_rate is None else (1.0,)
    largest_rate = rate_of(P, G, loop.sample_time) if decay_rate is None else decay_rate
    for share in shares:
        rate = rounded_down(share * largest_rate) if decay_rate is None else decay_rate
        for digits in DIGITS:
            Q = short(P, digits)
            reach = np.einsum("ti,ij,tj->t", rows, np.linalg.inv(Q), rows).max()
            level = rounded_down((1 - SPARE) / reach)
            words = f"decay rate {rate:.6g} 1/s, P to {digits} digits"
            yield words, kind | {"P": Q.tolist(), "level": level, "decay_rate": rate}


def rate_of(P: Floats, G: Floats, step: float | None) -> float:
    """Return the largest alpha [1/s] with which V = z'Pz falls along every G, in floats."""
    factor = np.linalg.cholesky(P).T
    inner = factor @ G @ np.linalg.inv(factor)
    if step is None:
        return float(-np.linalg.eigvalsh((inner + inner.transpose(0, 2, 1)) / 2)[:, -1].max())
    largest = float(np.linalg.norm(inner, 2, axis=(1, 2)).max())
    return -float(np.log(max(largest, 1e-150))) / step
