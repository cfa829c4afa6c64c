"""The speed in turbulence: inputs, least torque, greatest torque of the rotor, and verdicts."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.overspeed.rotor_torque import (
    greatest,
    greatest_at_any_speed,
)
from takagi.certificates.checker.turbine.overspeed.sent import LeastTorque
from takagi.certificates.checker.turbine.overspeed.speed_claim import (
    is_held,
    probability_bound,
    speed_at,
    speed_failure,
)
from takagi.certificates.checker.turbine.overspeed.speed_inputs import StatedSpeed, Turbulence
from tests.certificates.pinned.turbine.values import Named, said
from tests.certificates.recorded.answers import recorded

F = Fraction
LOST = "(left out)"
CLAIM = ("claims", 0)
STOP = (*CLAIM, "measurement", "torsion_filter")
# Entries of the file that the claim reads: at the limits of what is read, and beyond.
CHANGES: dict[str, tuple[tuple[str | int, ...], Any]] = {
    "a probability of 1": ((*CLAIM, "probability"), 1.0),
    "a probability below 1": ((*CLAIM, "probability"), 0.999999),
    "a probability of 0": ((*CLAIM, "probability"), 0.0),
    "a window as wide as the speed": ((*CLAIM, "window"), 1.437),
    "a window below the speed": ((*CLAIM, "window"), 1.436999),
    "an inertia of one value": ((*CLAIM, "uncertainty", "inertia"), [0.9, 0.9]),
    "an inertia of 0": ((*CLAIM, "uncertainty", "inertia"), [0.0, 0.9]),
    "an inertia of three values": ((*CLAIM, "uncertainty", "inertia"), [0.9, 1.0, 1.1]),
    "an excess of 0": ((*CLAIM, "uncertainty", "torque_excess"), 0.0),
    "an excess below 0": ((*CLAIM, "uncertainty", "torque_excess"), -1e-9),
    "an excess": ((*CLAIM, "uncertainty", "torque_excess"), 0.25),
    "all passed": ((*STOP, "passed"), 1.0),
    "more than all passed": ((*STOP, "passed"), 1.000001),
    "nothing passed": ((*STOP, "passed"), 0.0),
    "less than nothing passed": ((*STOP, "passed"), -0.000001),
    "no frequency": ((*STOP, "frequency"), LOST),
    "a frequency of 0": ((*STOP, "frequency"), 0.0),
    "no band-stop": (STOP, LOST),
    "no filter": ((*CLAIM, "measurement", "speed_filter"), LOST),
    "no filters": ((*CLAIM, "measurement"), LOST),
    "a horizon of 0": ((*CLAIM, "horizon"), 0.0),
    "a highest wind of 0": ((*CLAIM, "highest_wind"), 0.0),
    "a least estimate of 0": ((*CLAIM, "least_estimate"), 0.0),
    "a speed of 0": ((*CLAIM, "speed"), 0.0),
    "no wind": ((*CLAIM, "wind"), LOST),
    "no rate": ((*CLAIM, "wind", "rate"), LOST),
    "a rate of 0": ((*CLAIM, "wind", "rate"), 0.0),
    "no family": ((*CLAIM, "uncertainty"), LOST),
    "no filter of the wind": (("gains", "wind_filter"), 0.0),
    "no rate of the torque": (("model", "torque_rate_limit"), 0.0),
    "another least pitch": (("gains", "pitch_min"), 0.001),
    "another greatest pitch": (("gains", "pitch_max"), 1.0),
    "another filter than the controller's": ((*CLAIM, "measurement", "speed_filter"), 9.0),
}


def document() -> Any:
    return json.loads(next(recorded("turbulence-speed"))[1])


def stated_in(whole: Any) -> Any:
    data = read_text(json.dumps(whole), "certificate")
    return said(StatedSpeed.read, data["claims"][0], data, "claims[0]")


@cache
def stated() -> StatedSpeed:
    """Return the recorded claim."""
    found: StatedSpeed = stated_in(document())
    return found


def changed(place: tuple[str | int, ...], value: Any) -> Any:
    """Return the document with one entry changed; the controller's filters follow the claim's.

    They do not where the change is of the low-pass.
    """
    whole: Any = deepcopy(document())
    holder = whole
    for step in place[:-1]:
        holder = holder[step]
    if value == LOST:
        del holder[place[-1]]
    else:
        holder[place[-1]] = value
    if place[:3] == STOP[:3] and "speed_filter" not in place:
        whole["controller"]["measurement"] = deepcopy(whole["claims"][0]["measurement"])
    return whole


def of_inputs() -> Named:
    """Yield what the claim reads, without the tables of turbine and law."""
    for name, (place, value) in CHANGES.items():
        # Without measurement there is nothing for the controller to follow.
        if place == (*CLAIM, "measurement"):
            whole = document()
            del whole["claims"][0]["measurement"], whole["controller"]
        else:
            whole = changed(place, value)
        found = stated_in(whole)
        if isinstance(found, str):
            yield name, found
            continue
        yield name, [getattr(found, part) for part in StatedSpeed.__dataclass_fields__][2:]
        yield f"{name}: kappa, delay", (found.kappa, found.delay)


def tilted(stated: StatedSpeed) -> StatedSpeed:
    """Return a law whose columns differ from node to node, with feed-forward and a wide overlap."""
    law = stated.law
    plain: dict[str, Any] = {}
    for name in ("speed", "effort", "gamma", "inertia_limit"):
        column = getattr(law, name)
        plain[name] = [value * (1 + F(j % 5, 40)) for j, value in enumerate(column)]
    plain["inertia_limit"] = [F(j % 4, 500) for j in range(len(law.inertia_limit))]
    return replace(stated, law=replace(law, **plain, overlap=F(1, 20)))


def of_least_torque() -> Named:
    """Yield the parts of the tables, and the torque that is asked for at least."""
    for words, one in (("as stated", stated()), ("tilted", tilted(stated()))):
        law = one.law
        nodes = law.wind
        for least in (F(1), nodes[0], nodes[1], (nodes[1] + nodes[2]) / 2, nodes[-2], nodes[-1]):
            name, asked = f"{words}, from {least}", said(LeastTorque, law, least)
            if isinstance(asked, str):
                yield name, asked
                continue
            yield name, [(*part, fed) for parts, fed in asked.intervals for part in parts]
            for speed in (F(1, 2), F(9, 10), F(13, 10), F(3, 2), F(3)):
                yield f"{name}, above {speed}", asked.above(speed)
        asked = LeastTorque(law, F(1))
        part = F(1), F(-1, 20), F(1, 5), F(3, 10)
        for signal in (F(2), F(1), F(19, 20), F(9, 10), F(-9)):
            yield f"{words}, signal {signal}", asked._of([part], F(1, 100), signal)


def of_driving(pitch_min: Fraction) -> Named:
    """Yield what the rotor gives at most, over speeds and winds, at pitch from a lower limit on."""
    plant = replace(stated().plant, pitch_min=pitch_min)
    yield "anywhere", greatest_at_any_speed(plant, F(44, 5))
    for speeds in ((F(6, 5), F(3, 2)), (F(1, 100), F(40))):
        yield f"speeds {speeds}", greatest(plant, speeds, F(44, 5))


def refusals() -> dict[str, dict[str, Any]]:
    """Return changes of the claim that a condition before the last one refuses, or just not."""
    one = stated()
    mean, start = one.wind.mean, speed_at(one.law, one.wind.mean)
    nodes = one.law.wind
    found: dict[str, dict[str, Any]] = {}
    found["an estimate above the mean wind"] = {"least_estimate": mean + F(1, 10**9)}
    found["the highest wind is the mean"] = {"highest": mean}
    found["the highest wind is above twice the mean"] = {"highest": 2 * mean + F(1, 10**9)}
    found["a speed of the start"] = {"speed": start}
    found["a certain highest wind"] = {"highest": mean + one.wind.deviation}
    found["a highest wind within the deviation"] = {"highest": mean + one.wind.deviation / 2}
    exact = probability_bound(one.wind, one.highest, one.horizon) or F(0)
    found["a probability below the bound"] = {"probability": exact - F(1, 10**30)}
    for at in (nodes[0] - F(1, 10), nodes[0], nodes[-1], nodes[-1] + F(1, 10)):
        winds = replace(one.wind, mean=at)
        found[f"a mean wind of {at}"] = {"wind": winds, "least_estimate": F(1)}
        found[f"a mean wind of {at}"] |= {"highest": at + 1, "speed": F(3)}
    return found


def of_refusals() -> Named:
    """Yield the words for claims that are refused before the torques are compared."""
    for name, changes in refusals().items():
        changed: Any = replace(stated(), **changes)
        yield name, said(speed_failure, changed)


# The rotor is held from a speed between the two on.
HELD: dict[str, tuple[Fraction, Fraction, dict[str, Any]]] = {
    "as stated": (F("1.436534"), F("1.436535"), {}),
    "with an excess": (F("1.448344"), F("1.448345"), {"excess": F(1, 1000)}),
    "a slow filter": (F("1.454693"), F("1.454694"), {"corner": F(2)}),
    "a short window": (F("1.679163"), F("1.679164"), {"window": F(1, 40)}),
    "a wide window": (F("1.450843"), F("1.450844"), {"window": F(1, 2)}),
    "from 4 m/s on": (F("1.324491"), F("1.324492"), {"least_estimate": F(4)}),
}


def of_held(name: str) -> Named:
    """Yield whether the rotor is held, at two speeds that are a millionth apart."""
    *speeds, changes = HELD[name]
    for speed in speeds:
        yield f"{speed}", is_held(replace(stated(), **changes, speed=speed))


def of_equal_torques() -> Named:
    """Yield whether the rotor is held where the generator takes what the rotor gives, to the digit.

    From 24.5 m/s on the law asks for rated torque, whatever the delay; it follows at once.
    """
    one = replace(stated(), speed=F(3), least_estimate=F("24.6"), torque_rate=F(10**9))
    equal = one.law.rated_torque * one.plant.gear_per_inertia
    equal -= greatest(one.plant, (one.speed, one.speed), one.highest)
    for less in (-1, 0, 1):
        yield f"{less}", is_held(replace(one, excess=equal - less * F(1, 10**30)))


LIMITS = (
    "an estimate of the mean wind",
    "the probability of the bound",
    "a highest wind of twice the mean",
    "a rotor that is braked",
)


def of_limits(name: str) -> Named:
    """Yield the words at a limit that is kept, or where no torque drives the rotor."""
    one = stated()
    exact = probability_bound(one.wind, one.highest, one.horizon) or F(0)
    changed: Any = {
        "an estimate of the mean wind": {"least_estimate": one.wind.mean},
        "the probability of the bound": {"probability": exact},
        "a highest wind of twice the mean": {"highest": 2 * one.wind.mean, "speed": F(11, 5)},
        "a rotor that is braked": {"excess": F(-1)},
    }[name]
    yield name, said(speed_failure, replace(one, **changed))


def of_bounds() -> Named:
    """Yield the bound of the probability, and the speed at the winds of the tables."""
    law, wind = stated().law, Turbulence(F(5), F(7, 10), F(3, 50))
    for highest in (F(5), F(57, 10) - F(1, 10**9), F(57, 10), F(8), F(10)):
        yield f"bound {highest}", probability_bound(wind, highest, F(600))
    for at in (law.wind[0], law.wind[1], law.wind[2] + F(1, 8), law.wind[-2], law.wind[-1]):
        yield f"speed at {at}", (speed_at(law, at), speed_at(tilted(stated()).law, at))


def groups() -> dict[str, Callable[[], Named]]:
    found: dict[str, Callable[[], Named]] = {
        "speed inputs": of_inputs,
        "speed least torque": of_least_torque,
        "speed refusals": of_refusals,
        "speed bounds": of_bounds,
        "speed equal torques": of_equal_torques,
    }
    found |= {f"speed driving {low}": partial(of_driving, low) for low in (F(0), F(1, 10), F(9))}
    found |= {f"speed held, {name}": partial(of_held, name) for name in HELD}
    return found | {f"speed limits, {name}": partial(of_limits, name) for name in LIMITS}
