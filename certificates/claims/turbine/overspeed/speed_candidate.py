"""The candidate of a claim of kind ``turbulence-speed``: the least speed for a probability.

The highest wind follows from the probability, and the speed from the highest wind: the least speed
at which the generator is shown to take more than the rotor gives.
Nothing is proved here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.turbine.overspeed.speed_claim import (
    is_held,
    probability_bound,
    speed_at,
    speed_failure,
)
from takagi.certificates.checker.turbine.overspeed.speed_inputs import StatedSpeed
from takagi.certificates.claims.turbine.stated_controller import stated_controller
from takagi.models.errors import ModelError

# Steps of the highest wind [m/s] and of speeds [rad/s]; the greatest speed to try, over rated.
WIND_STEP, SPEED_STEP = Fraction(1, 1000), Fraction(1, 2000)
FASTEST = 2
# How far below the speed the torque's past is followed [rad/s].
WINDOWS = (Fraction(1, 10), Fraction(1, 5))


@dataclass(frozen=True, slots=True)
class SpeedAsked:
    """What the claim is asked for.

    Attributes
    ----------
    mean, deviation : of the wind [m/s];  rate : rms of its rate [m/s^2].
    probability, horizon : p and T [s].
    least_estimate : the claim ends at a smaller wind estimate [m/s]; up to the first wind of the
        law's tables this is no condition.
    excess : of the rotor's torque over the table's, over J [rad/s^2].
    """

    mean: float
    deviation: float
    rate: float
    probability: float
    horizon: float
    least_estimate: float
    excess: float = 0.0


def turbulence_speed_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
    asked: SpeedAsked,
) -> dict[str, Any]:
    """Return the claim as plain data, with the least speed that is shown.

    Parameters
    ----------
    controller, inertia : as ``running_loop_claim`` takes them.

    Raises
    ------
    Refused : no speed up to twice the rated one can be shown, no wind below twice the mean wind is
        rare enough, or the law has no filter of the measured speed or of the wind.
    ModelError : a number that was asked for is none that such a claim can have.
    """
    claim: dict[str, Any] = {
        "kind": "turbulence-speed",
        "name": f"rotor speed in turbulence, mean wind {asked.mean:g} m/s",
        "wind": {"mean": asked.mean, "deviation": asked.deviation, "rate": asked.rate},
        "horizon": asked.horizon,
        "probability": asked.probability,
        "least_estimate": asked.least_estimate,
        "uncertainty": {"inertia": list(inertia), "torque_excess": asked.excess},
        **stated_controller(controller, gains, "measurement"),
    }
    rated = float(model["rated_rotor_speed"])
    first = claim | {"highest_wind": asked.mean, "speed": rated, "window": 0.1}
    data = read_text(
        json.dumps({"model": model, "gains": gains, "controller": controller, "claim": first}),
        "candidate",
    )
    try:
        stated = StatedSpeed.read(data["claim"], data, "claim")
    except CertificateError as error:
        raise ModelError(f"no claim of a speed in turbulence can be made: {error}") from error
    stated = replace(stated, highest=_rare(stated))
    found = _slowest(stated)
    if failure := speed_failure(found):
        raise Refused(failure)
    claim |= {
        "highest_wind": float(found.highest),
        "speed": float(found.speed),
        "window": float(found.window),
    }
    return claim


def _rare(stated: StatedSpeed) -> Fraction:
    """Return the least wind that is reached with at most the probability."""
    mean = stated.wind.mean

    def is_rare(step: int) -> bool:
        bound = probability_bound(stated.wind, mean + step * WIND_STEP, stated.horizon)
        return bound is not None and bound <= stated.probability

    return mean + _least(is_rare, int(mean / WIND_STEP), "no wind is rare enough") * WIND_STEP


def _slowest(stated: StatedSpeed) -> StatedSpeed:
    """Return the claim with about the least speed that can be shown."""
    start = int(speed_at(stated.law, stated.wind.mean) / SPEED_STEP) + 1
    most = int(FASTEST * stated.plant.rated_speed / SPEED_STEP)

    def at(step: int) -> StatedSpeed | None:
        for window in WINDOWS:
            found = replace(stated, speed=(start + step) * SPEED_STEP, window=window)
            if is_held(found):
                return found
        return None

    place = _least(lambda step: at(step) is not None, most - start, "no speed can be shown")
    found = at(place)
    if found is None:
        raise Refused("no speed can be shown")
    return found


def _least(holds: Callable[[int], bool], most: int, why: str) -> int:
    """Return the least number that holds, where with a number every larger one holds."""
    if not holds(most):
        raise Refused(why)
    low, high = -1, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
