"""Requests the set and the decay of a loop whose law measures outputs and has an observer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.observed_loop import ranges_kept, whole_loops
from takagi.certificates.checker.words.sentences.observed_loop import starts
from takagi.certificates.requests.loop.decimals import (
    DIGITS,
    as_read,
    floats,
    rounded_down,
    short,
    stack_of,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.valid_level import SPARE
from takagi.certificates.requests.request import Attempt, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# The set is searched at this share of the largest rate: at the largest rate it would be small.
SHARE_OF_RATE, FASTEST = 0.25, 1e6
BACK_OFF = (0.999, 0.99, 0.9, 0.5, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ObservedLoop:
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
        found = np.asarray(self.input_limits, dtype=np.float64)
        m = loop.model.B.shape[2]
        if found.shape != (m,) or not (found > 0).all():
            raise ModelError(f"input_limits: {m} positive numbers are needed, not {found}")
        return {"input_limits": found.tolist()}


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
    from takagi.lmi.analysis.decay_rate import fast_decay
    from takagi.lmi.analysis.start_set import start_set

    if not len(rows):
        raise ModelError(
            f"model {loop.model.name!r} has no box of states, so nothing limits the set; give the "
            "states ranges"
        )
    if rate is None:
        answer = fast_decay(G, sample_time=loop.sample_time)
        if answer.P is None or not (answer.decay_rate or 0.0) > 0:
            return None, answer.diagnosis or "no function decays", answer.status
        rate = SHARE_OF_RATE * min(answer.decay_rate or 0.0, FASTEST)
    found = start_set(
        G, rows, starts_of(loop), decay_rate=1.0001 * rate, sample_time=loop.sample_time
    )
    return found.P, found.diagnosis, found.words


def _claims(
    loop: ClaimedLoop,
    kind: dict[str, Any],
    G: Floats,
    rows: Floats,
    P: Floats,
    asked: float | None,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield claims with their words, the strongest first."""
    shares = BACK_OFF if asked is None else (1.0,)
    found = rate_of(P, G, loop.sample_time) if asked is None else asked
    for share in shares:
        rate = rounded_down(share * found) if asked is None else asked
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
