"""Requests bounds of the overshoot and the settling time of the state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.document.model_data import rounded_down, rounded_up, short
from takagi.certificates.requests.decay import common_function
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import state_halves
from takagi.certificates.requests.request import Attempt, Request, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

DIGITS = (4, 6, 9, 12)
# Fractions of the largest decay rate: a lower rate gives a rounder ellipsoid and less overshoot.
SHARES = (0.95, 0.8, 0.6, 0.4)
# The share by which each number is moved to the safe side before it is rounded.
SPARE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Transient(Request):
    """|x(t)| <= kappa e^(-alpha t) |x(0)|, and the time to a fraction of the start.

    Attributes
    ----------
    settled_share : between 0 and 1; 0.02 is the usual 2 % settling time.
    decay_rate : alpha in 1/s; None takes, of a few rates, the one that settles soonest.
    scales : (n,) size of each state; None takes the half-widths of the model's box where all
        states have one, else 1.
    name : of the claim.
    """

    includes_decay: ClassVar[bool] = True

    settled_share: float = 0.02
    decay_rate: float | None = None
    scales: ArrayLike | None = None
    name: str = "overshoot and settling time"

    def __post_init__(self) -> None:
        if not 0 < self.settled_share < 1:
            raise ModelError(f"settled_share is {self.settled_share!r}; between 0 and 1 is needed")
        if self.decay_rate is not None and not (
            np.isfinite(self.decay_rate) and self.decay_rate > 0
        ):
            raise ModelError(f"decay_rate is {self.decay_rate!r}; a positive number is needed")

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``transient``."""
        scales = self._scales(loop)
        if self.decay_rate is None:
            fastest = common_function(loop)
            largest_rate = min(fastest.decay_rate or 0.0, 1e6)
            rates = [rounded_down(share * largest_rate) for share in SHARES if largest_rate > 0]
            diagnosis = fastest.diagnosis
        else:
            rates, diagnosis = [self.decay_rate], ""
        claims: list[tuple[float, str, dict[str, Any]]] = []
        for rate in rates:
            answer = common_function(loop, rate)
            diagnosis = diagnosis or answer.diagnosis
            if answer.P is not None:
                claims += self._claims(loop, np.asarray(answer.P), rate, scales)
        named = {"name": self.name}
        if not claims:
            idle = _claim(np.eye(len(scales)), self.decay_rate or 1.0, scales, 1.0, 1.0)
            unproved = idle | {"settled_share": self.settled_share, "settling_time": 1.0}
            if loop.sample_time is not None:
                unproved["settling_time"] = loop.sample_time
            return first_proved(loop, [(diagnosis or "no candidate P", unproved | named)])
        best = sorted(claims, key=lambda claim: claim[0])
        return first_proved(loop, [(words, claim | named) for _, words, claim in best])

    def _claims(
        self, loop: ClaimedLoop, P: Floats, rate: float, scales: Floats
    ) -> Iterator[tuple[float, str, dict[str, Any]]]:
        for digits in DIGITS:
            rounded = short(P, digits)
            sizes = np.linalg.eigvalsh(rounded * scales * scales[:, None])
            if sizes[0] <= 0:
                continue
            lower = rounded_down(float(sizes[0]) * (1 - SPARE))
            kappa = rounded_up(float(np.sqrt(sizes[-1] / lower)) * (1 + SPARE), 4)
            settled = np.log(kappa / self.settled_share) / rate * (1 + SPARE)
            claim = _claim(rounded, rate, scales, lower, kappa) | {
                "settled_share": self.settled_share,
                "settling_time": _whole(settled, loop.sample_time),
            }
            words = f"overshoot {kappa:.4g}, settled after {settled:.4g} s, P to {digits} digits"
            yield claim["settling_time"], words, claim

    def _scales(self, loop: ClaimedLoop) -> Floats:
        n = loop.exact.order
        if self.scales is None:
            halves = state_halves(loop)
            return halves if np.isfinite(halves).all() and (halves > 0).all() else np.ones(n)
        scales = np.asarray(self.scales, dtype=np.float64)
        if scales.shape != (n,) or not np.all(np.isfinite(scales) & (scales > 0)):
            raise ModelError(f"scales = {self.scales!r}: {n} positive numbers are needed")
        return scales


def _whole(time: float, step: float | None) -> float:
    """Return the time rounded up, to whole samples in discrete time.

    Of a step with many digits a multiple may have too many for a float: the next that has not.
    """
    if step is None:
        return rounded_up(time, 4)
    exact, least = Decimal(repr(step)), int(np.ceil(time / step))
    multiples = (exact * count for count in range(least, 10 * least + 1))
    return next((float(t) for t in multiples if Decimal(repr(float(t))) == t), float(exact * least))


def _claim(P: Floats, rate: float, scales: Floats, lower: float, kappa: float) -> dict[str, Any]:
    return {
        "name": "overshoot and settling time",
        "kind": "transient",
        "decay_rate": rate,
        "scales": scales.tolist(),
        "lower": lower,
        "overshoot": kappa,
        "P": P.tolist(),
    }
