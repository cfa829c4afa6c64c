"""Requests the largest error of every gain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.document.model_data import rounded_down, short
from takagi.certificates.requests.decay import common_function
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, Request, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Fraction of the decay rate found: robustness to rounding costs decay rate.
RATE_SHARE = 0.5
BACK_OFF = (0.99, 0.9, 0.5, 0.1)
# Steps of 0 say no more than decay does: without larger ones this one is tried.
LEAST_STEP = 1e-9
P_DIGITS = 9
HALVINGS = 30


@dataclass(frozen=True, slots=True, eq=False)
class GainRounding(Request):
    """The largest errors of all gains, with decay at ``decay_rate`` alpha [1/s].

    Attributes
    ----------
    decay_rate : alpha that has to remain; None takes half of what is found.
    absolute : (m, n) steps; the largest multiple of them is searched. None searches the largest
        ``relative`` step, which is a fraction of each gain.
    """

    includes_decay: ClassVar[bool] = True

    decay_rate: float | None = None
    absolute: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``gain-rounding``; the step is reduced until the claim is proved.

        Raises
        ------
        ModelError : there are no gains, or steps of another shape.
        """
        if loop.gains is None:
            raise ModelError("there are no gains to be rounded; give gains, or leave this claim")
        shape = _shape(self.absolute, loop)
        answer = common_function(loop)
        solver = str(answer.solver.get("status", ""))
        rate = self.decay_rate
        if rate is None:
            rate = rounded_down(RATE_SHARE * min(max(answer.decay_rate or 0.0, 0.0), 1e6))
        # The function of the fastest decay is often nearly singular. A function for the rate that
        # must remain is better conditioned, and usually allows larger errors.
        functions = [P for P in (common_function(loop, rate).P, answer.P) if P is not None]
        searches = [
            _Search.of(loop, short(np.asarray(P), P_DIGITS), rate, shape)
            for P in functions or [np.eye(loop.A.shape[1])]
        ]
        best = max(searches, key=lambda search: search.largest[0])
        return first_proved(loop, best.claims(), solver)


def _shape(absolute: ArrayLike | None, loop: ClaimedLoop) -> Floats | None:
    if absolute is None:
        return None
    assert loop.gains is not None
    steps = np.asarray(absolute, dtype=np.float64)
    shape = loop.gains.shape[1:]
    if steps.shape != shape or not (np.isfinite(steps).all() and steps.min() >= 0 and steps.any()):
        raise ModelError(
            f"absolute has shape {steps.shape}; steps >= 0 of shape {shape}, one for each gain, "
            "are needed, not all 0"
        )
    return steps


@dataclass(frozen=True, eq=False)
class _Search:
    """The exact inequality in floating point: its least eigenvalue over a step and a common tau."""

    loop: ClaimedLoop
    P: Floats
    rate: float
    shape: Floats | None
    decrease: Floats
    effect: Floats
    unit: Floats
    weights: Floats

    @classmethod
    def of(cls, loop: ClaimedLoop, P: Floats, rate: float, shape: Floats | None) -> _Search:
        assert loop.gains is not None
        step = loop.sample_time
        PG = P @ loop.A
        if step is None:
            decrease = -(PG + PG.transpose(0, 2, 1) + 2 * rate * P)
        else:
            top = np.broadcast_to(np.exp(-2 * rate * step) * P, PG.shape)
            low = np.broadcast_to(P, PG.shape)
            decrease = np.block([[top, PG.transpose(0, 2, 1)], [PG, low]])
        r = len(loop.model.B)
        columns = P @ loop.model.B
        delta = np.abs(loop.gains) if shape is None else np.broadcast_to(shape, loop.gains.shape)
        # A law with weights of its own has as many steps as gains.
        delta = np.broadcast_to(delta, (r, *delta.shape[1:])) if len(delta) == 1 else delta
        steps = np.einsum("jk,jkl->jkl", delta.sum(axis=2), delta)
        # Inputs of different size are scaled: tau_k is t over the size of column k.
        sizes = np.sqrt(np.maximum((columns**2).sum(axis=1).max(axis=0), 1e-300))
        reach = np.sqrt(np.maximum(steps.sum(axis=2).max(axis=0), 1e-300))
        weights = reach / sizes
        effect = loop.per_pair(np.einsum("ink,k,imk->inm", columns, weights, columns), "vertex")
        unit = np.einsum("jkl,k->jl", steps, 1 / weights)
        diagonal = loop.per_pair(unit[:, :, None] * np.eye(len(P)), "gain")
        return cls(loop, P, rate, shape, decrease, effect, diagonal, weights)

    def holds(self, size: float, t: float) -> bool:
        """Return whether all inequalities hold at a step and a factor of tau, in floats."""
        effect, step = t * self.effect, size**2 / t * self.unit
        inequality = self.decrease.copy()
        if self.loop.sample_time is None:
            inequality -= effect
            inequality -= step
        else:
            n = len(self.P)
            inequality[:, :n, :n] -= step
            inequality[:, n:, n:] -= effect
        return bool(np.linalg.eigvalsh(inequality)[:, 0].min() > 0)

    def claims(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield the claims, the largest step first."""
        size, t = self.largest
        assert self.loop.gains is not None
        shape = np.zeros(self.loop.gains.shape[1:]) if self.shape is None else self.shape
        tau = [float(f"{value:.4g}") for value in t * self.weights]
        for share in BACK_OFF:
            step = rounded_down(share * size, 3) or LEAST_STEP
            absolute = [[rounded_down(step * float(v), 3) for v in row] for row in shape]
            relative = step if self.shape is None else 0.0
            claim = {
                "name": f"rounding of the gains of {self.loop.model.name or 'the model'}",
                "kind": "gain-rounding",
                "decay_rate": self.rate,
                "relative": relative,
                "absolute": absolute,
                "tau": tau,
                "P": self.P.tolist(),
            }
            yield f"gains off by {step:.3g} times themselves or the given steps", claim

    @cached_property
    def largest(self) -> tuple[float, float]:
        """Return the largest step, and its factor of tau, over a grid of factors."""
        best, best_factor = 0.0, 1.0
        # The best factor is not known beforehand. The bisection runs only where the best step so
        # far can be exceeded.
        for t in np.logspace(-8, 4, 73):
            low, high = best, max(2 * best, 1e-6)
            if not self.holds(low, t) or (best and not self.holds(1.01 * best, t)):
                continue
            while self.holds(high, t) and high < 1e6:
                low, high = high, 4 * high
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if self.holds(middle, t) else (low, middle)
            best, best_factor = low, float(t)
        return best, best_factor
