"""Runs outside the certified class: a wider wind class, starts farther away, other plants.

wind, wind-error, wind-rate   the class of every cell, times a factor
start                         starts with V up to this, in place of 1
inertia                       true inertia from LOW to HIGH of nominal
wake                          pitch more effective than with a frozen wake: share up to this
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.models.errors import ModelError, did_you_mean

KINDS = ("wind", "wind-error", "wind-rate", "start", "inertia", "wake")
MOST = 1000.0


@dataclass(frozen=True, slots=True)
class Beyond:
    """How far a campaign goes beyond the certified class; the defaults stay inside it.

    Attributes
    ----------
    name : the request, such as ``wind=3``; ``inside`` for the certified loop itself.
    wind_error, wind_rate : factors on every cell's class [-].
    start : starts have V up to this [-].
    inertia : true over nominal inertia, or None for the certificate's.
    wake : pitch effectiveness up to this share: equilibrium wake 0, frozen wake 1 [-].
    """

    name: str
    wind_error: float = 1.0
    wind_rate: float = 1.0
    start: float = 1.0
    inertia: tuple[float, float] | None = None
    wake: float = 1.0

    def loop(self, loop: CertifiedLoop) -> CertifiedLoop:
        """Return the loop with this class and these plants; its bounds are the certificate's."""
        return replace(
            loop,
            wind_error=self.wind_error * loop.wind_error,
            wind_rate=self.wind_rate * loop.wind_rate,
            inertia=self.inertia or loop.inertia,
        )


INSIDE = Beyond("inside")


def beyond_of(text: str) -> Beyond:
    """Return the value for a request ``3``, ``wind=3``, ``start=4``, ``inertia=0.8:1.2``, ...

    Raises
    ------
    ModelError : another kind, or a number that is not positive.
    """
    kind, _, value = text.rpartition("=")
    kind = kind.strip() or "wind"
    if kind not in KINDS:
        raise ModelError(
            f"--beyond {text}: {kind!r} is not one of {', '.join(KINDS)}"
            f"{did_you_mean(kind, KINDS)}; write wind=3 or inertia=0.8:1.2"
        )
    numbers = [_positive(part, text) for part in value.split(":")]
    if len(numbers) != 1 + (kind == "inertia") or numbers != sorted(numbers):
        raise ModelError(
            f"--beyond {text}: {'two numbers, LOW:HIGH,' if kind == 'inertia' else 'one number'} "
            f"after {kind}= is needed"
        )
    name, first = f"{kind}={value}", numbers[0]
    if kind == "start" and first <= 1:
        raise ModelError(
            f"--beyond {text}: starts up to V = {first:g} are within the certificate; give a "
            "number above 1, or leave --beyond out"
        )
    if kind == "inertia":
        return Beyond(name, inertia=(numbers[0], numbers[1]))
    if kind == "wind":
        return Beyond(name, wind_error=first, wind_rate=first)
    if kind == "wind-error":
        return Beyond(name, wind_error=first)
    if kind == "wind-rate":
        return Beyond(name, wind_rate=first)
    return Beyond(name, start=first) if kind == "start" else Beyond(name, wake=first)


def _positive(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value <= MOST:
        raise ModelError(f"--beyond {where}: {text!r} is no number above 0 and up to {MOST:g}")
    return value


# The requests that ``--beyond all`` stands for.
STANDARD = tuple(
    beyond_of(text)
    for text in (
        *(f"wind={factor}" for factor in (1.5, 2, 3, 5, 10)),
        *("wind-error=5", "wind-error=10", "wind-rate=5", "wind-rate=10"),
        *("start=2", "start=4", "inertia=0.8:1.2", "inertia=0.5:2", "wake=1.5", "wake=3"),
    )
)
