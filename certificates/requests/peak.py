"""Requests a bound on the output's peak under a bounded disturbance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.document.model_data import rounded_down, rounded_up, short
from takagi.certificates.requests.loop.disturbance_channel import (
    Output,
    Path,
    channel_evidence,
    disturbance_channel,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import best_multiplier, input_bounds, largest_level
from takagi.certificates.requests.request import Attempt, first_proved, require_positive
from takagi.lmi.analysis.disturbance.peak_to_peak import largest_eigenvalue
from takagi.models.arrays import Floats

# Fractions added to P or to the bound, tried in order until the rounded numbers prove the claim.
BACK_OFF = (1e-5, 1e-4, 1e-3, 1e-2, 0.1)
DIGITS = (6, 9, 12, 15)
# For one vertex: relative margins of the bound, and the reduction that is tried with each.
ROOM, SLIGHTLY = (1e-5, 1e-4, 1e-3), (1e-5, 1e-4)
# The relative increase of the bound that is accepted for fewer digits of P.
SHORT = 1e-4

NAME = "peak of the output under bounded disturbance"


@dataclass(frozen=True, slots=True, eq=False)
class Peak:
    """|y| <= gain b at all times, from rest, for every disturbance with |w|_2 <= b.

    Attributes
    ----------
    gain : None takes slightly more than the least gain found.
    disturbance_norm : b; None takes the largest that keeps the state in the model's box, but at
        most 1; without a box it takes 1.
    decay_rate : alpha [1/s] of the set; None searches the best one.
    disturbance, output, entering : the channel, as in ``loop.disturbance_channel``.
    name : of the claim.
    """

    gain: float | None = None
    disturbance_norm: float | None = None
    decay_rate: float | None = None
    disturbance: str | None = None
    output: Output | None = None
    entering: tuple[int, ...] | None = None
    name: str = NAME

    def __post_init__(self) -> None:
        require_positive(gain=self.gain, disturbance_norm=self.disturbance_norm)

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``peak``."""
        evidence = channel_evidence(loop, self.disturbance, self.output, self.entering)
        path = disturbance_channel(loop, evidence)
        if len(path[0]) == 1:
            attempt = self._by_equation(loop, evidence, path)
            if attempt is not None and attempt.proved:
                return attempt
        return self._by_program(loop, evidence, path)

    def _by_equation(
        self, loop: ClaimedLoop, evidence: dict[str, Any], path: Path
    ) -> Attempt | None:
        """Return the bound proved by P of one vertex's Lyapunov equation; None if there is no P."""
        from takagi.lmi.analysis.disturbance.guessed_function import OneVertex

        vertex = OneVertex.of(*(stack[0] for stack in path), step=loop.sample_time)
        rate = vertex.best_rate() if self.decay_rate is None else self.decay_rate
        if rate is None:
            return None
        shapes = (vertex.with_room(rate, room) for room in ROOM)
        functions = ((P, vertex.sigma(rate)) for P in shapes if P is not None)
        claims = (
            claim
            for P, multiplier in functions
            for claim in self._claims(loop, evidence, path, P, multiplier, SLIGHTLY)
        )
        first = next(claims, None)
        return first and first_proved(loop, chain([first], claims), "Lyapunov equation")

    def _by_program(self, loop: ClaimedLoop, evidence: dict[str, Any], path: Path) -> Attempt:
        from takagi.lmi import peak_gain

        answer = peak_gain(*path, sample_time=loop.sample_time, decay_rate=self.decay_rate)
        solver = str(answer.solver.get("status", ""))
        identity = np.eye(path[0].shape[1])
        idle = _claim(
            self.name, evidence, identity, 1.0, 1.0, self.disturbance_norm or 1.0, self.gain or 1.0
        )
        if answer.P is None:
            return first_proved(loop, [(answer.diagnosis or "no bound was found", idle)], solver)
        rate, step = answer.decay_rate or 0.0, loop.sample_time
        multiplier = 2.0 * rate if step is None else -float(np.expm1(-2.0 * rate * step))
        claims = self._claims(loop, evidence, path, answer.P, multiplier, BACK_OFF)
        unproved = ("no set fits the model's box", idle)
        return first_proved(loop, claims, solver, idle=unproved)

    def _claims(
        self,
        loop: ClaimedLoop,
        evidence: dict[str, Any],
        path: Path,
        P: Floats,
        multiplier: float,
        back_off: tuple[float, ...],
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        A, B, C, D = path
        discrete = loop.sample_time is not None
        for increase in back_off:
            candidates = []
            for digits in DIGITS:
                rounded = short(P, digits)
                unit_level, s = best_multiplier(A, B, rounded, discrete=discrete, start=multiplier)
                if not np.isfinite(unit_level):
                    continue
                size = self.disturbance_norm or _fitting(loop, evidence, rounded, unit_level)
                s, level = rounded_down(s, 9), rounded_up(unit_level * size**2 * (1 + increase), 9)
                if s <= 0 or size <= 0 or level <= 0:
                    continue
                least_gain, share = least_peak(C, D, rounded / level * size**2)
                gain = self.gain or rounded_up(least_gain * (1 + increase))
                claim = _claim(self.name, evidence, rounded, level, s, size, gain)
                words = f"peak gain {gain:.6g} for |w| <= {size:.6g}, P to {digits} digits"
                candidates.append((least_gain, words, claim | ({"share": share} if share else {})))
            # Short numbers are preferred if they hardly increase the bound.
            accepted = min((gain for gain, _, _ in candidates), default=0.0)
            accepted *= 1 + max(increase, SHORT)
            yield from ((words, claim) for gain, words, claim in candidates if gain <= accepted)


def least_peak(C: Floats, D: Floats, ellipsoid: Floats) -> tuple[float, float]:
    """Return (gamma, t) least with gamma^2 diag((1 - t) X, t I) >= [C D]'[C D] at every blend.

    Parameters
    ----------
    C, D : (N, p, n), (N, p, q).
    ellipsoid : X, where x'Xx <= 1 for |w| <= 1.
    """
    spread = largest_eigenvalue(C @ np.linalg.solve(ellipsoid, C.transpose(0, 2, 1)))
    if not D.any():
        return float(np.sqrt(spread)), 0.0
    from scipy.optimize import minimize_scalar

    CD = np.concatenate([C, D], axis=2)
    q = D.shape[2]

    def gamma(t: float) -> float:
        weight = block_diag((1 - t) * ellipsoid, t * np.eye(q))
        return largest_eigenvalue(CD @ np.linalg.solve(weight, CD.transpose(0, 2, 1)))

    best = minimize_scalar(gamma, bounds=(1e-6, 1 - 1e-6), method="bounded")
    share = float(f"{best.x:.6g}")
    return float(np.sqrt(gamma(share))), share


def _fitting(loop: ClaimedLoop, evidence: dict[str, Any], P: Floats, unit_level: float) -> float:
    """Return the largest b <= 1 whose set lies in the box; ``unit_level`` is c for b = 1."""
    exact, at_input = loop.exact, evidence["disturbance"] == "inputs"
    limits = [1.0]
    if not at_input:
        limits += [
            float(min(-side[0], side[1]))
            for name, side in (exact.other_box or {}).items()
            if name in evidence.get("entering", exact.disturbances)
            and loop.model.E[:, :, exact.disturbances.index(name)].any()
        ]
    sides = bounded_inputs(exact) if at_input and loop.gains is not None else {}
    for k, side in sides.items():
        # |K x|_k <= b reach, and the disturbance at the input adds b.
        reach = input_bounds(loop, P, unit_level)[k]
        limits.append(0.999 * float(min(-side[0], side[1])) / (reach + 1))
    level = largest_level(loop, P)
    if np.isfinite(level):
        limits.append(0.999 * float(np.sqrt(level / unit_level)))
    return rounded_down(min(limits), 4)


def _claim(
    name: str,
    evidence: dict[str, Any],
    P: Floats,
    level: float,
    multiplier: float,
    size: float,
    gain: float,
) -> dict[str, Any]:
    return {
        "name": name,
        "kind": "peak",
        **evidence,
        "disturbance_norm": size,
        "gain": gain,
        "level": level,
        "multiplier": multiplier,
        "P": P.tolist(),
    }
