"""``turbulence-speed``: each condition alone, from both sides, in both checkers."""

from __future__ import annotations

import json
import math
from copy import deepcopy
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.overspeed import (
    sent,
)
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers
from takagi.certificates.cross_check.turbine.overspeed import asked
from takagi.models import nrel5mw
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry, everywhere, verdicts

F = Fraction
TURBINE = nrel5mw()


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("turbulence-speed"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


def sides(document: dict[str, Any], changes: dict[str, list[Change]]) -> None:
    """Assert that both checkers give the answer that a list of changes stands under."""
    for answer, listed in changes.items():
        for change in listed:
            changed = deepcopy(document)
            change(changed)
            assert verdicts(changed) == (answer, answer)


def other(**members: Any) -> Change:
    """Return a change of members of the claim; those of its wind are named like ``wind_mean``."""

    def change(document: Any) -> None:
        claim = document["claims"][0]
        for name, value in members.items():
            owner, _, part = name.partition("wind_")
            if part and not owner:
                claim["wind"][part] = value
            else:
                claim[name] = value

    return change


def braked(document: dict[str, Any]) -> None:
    """A law that asks for rated torque at every speed, and a rotor with little torque."""
    law = document["gains"]
    law["trim_effort"] = [1.0] * len(law["wind"])
    document["model"]["torque_constant"] *= 0.01


@pytest.mark.parametrize("end", [0, -1])
def test_the_mean_wind_is_a_schedule_wind(document: dict[str, Any], end: int) -> None:
    braked(document)
    at = document["gains"]["wind"][end]
    near = {"least_estimate": 1.0, "speed": 2.0, "probability": 0.9, "wind_deviation": 0.5}
    near |= {"highest_wind": at + 2.7}
    beyond = at - 0.001 if end == 0 else at + 0.001
    sides(
        document,
        {
            "PROVED": [other(wind_mean=at, **near)],
            "UNDECIDED": [other(wind_mean=beyond, **near)],
        },
    )


def test_the_least_estimate_is_the_mean_wind_at_most(document: dict[str, Any]) -> None:
    sides(
        document,
        {"PROVED": [other(least_estimate=5.0)], "UNDECIDED": [other(least_estimate=5.001)]},
    )


def test_the_rotor_starts_below_the_speed(document: dict[str, Any]) -> None:
    """A reference of one speed, which the rotor's speed is at first."""
    braked(document)
    count = len(document["gains"]["wind"])
    at = [entry("gains", "rotor_speed", value=[speed] * count) for speed in (1.4369, 1.437)]
    sides(document, {"PROVED": at[:1], "UNDECIDED": at[1:]})


def test_the_highest_wind_is_a_deviation_above_the_mean(document: dict[str, Any]) -> None:
    """The highest wind is 3.723 m/s above the mean; in no time the bound is 0.484."""
    loose = {"horizon": 1e-6, "probability": 0.99}
    sides(
        document,
        {
            "PROVED": [other(wind_deviation=3.723, **loose)],
            "UNDECIDED": [other(wind_deviation=3.724, **loose)],
        },
    )


def test_the_probability_from_both_sides(document: dict[str, Any]) -> None:
    wind = document["claims"][0]["wind"]
    xi = (8.723 - 5) ** 2 / (2 * wind["deviation"] ** 2)
    crossings = 600 * wind["rate"] / (math.pi * wind["deviation"])
    bound = math.exp(-xi) * (1 / math.sqrt(math.pi * xi) + crossings)
    sides(
        document,
        {
            "PROVED": [other(probability=bound * (1 + 1e-7))],
            "UNDECIDED": [other(probability=bound * (1 - 1e-7))],
        },
    )


def test_an_inertia_may_have_one_value(document: dict[str, Any]) -> None:
    document["claims"][0]["uncertainty"]["inertia"] = [0.9, 0.9]
    assert verdicts(document) == ("PROVED", "PROVED")


def short_and_excess(document: dict[str, Any]) -> None:
    """A window so short that the rate of the rotor's speed before counts, and an excess in it."""
    document["claims"][0]["window"] = 0.025
    document["claims"][0]["uncertainty"]["torque_excess"] = 1e-3


# A change of the claim, and two speeds a millionth apart: from between them on the rotor is held.
TURNS: dict[str, tuple[float, float, Change]] = {
    "as stated": (1.436534, 1.436535, other()),
    "with an excess": (
        1.448344,
        1.448345,
        entry("claims", 0, "uncertainty", "torque_excess", value=1e-3),
    ),
    "a slow filter": (1.454693, 1.454694, everywhere("speed_filter", value=2.0)),
    "a short window": (1.679163, 1.679164, other(window=0.025)),
    "a short window and an excess": (1.70838, 1.708381, short_and_excess),
    "a wide window": (1.450843, 1.450844, other(window=0.5)),
    "from 4 m/s on": (1.324491, 1.324492, other(least_estimate=4.0)),
}


@pytest.mark.parametrize("name", TURNS)
def test_both_checkers_turn_within_a_millionth(document: dict[str, Any], name: str) -> None:
    low, high, change = TURNS[name]
    change(document)
    sides(document, {"PROVED": [other(speed=high)], "UNDECIDED": [other(speed=low)]})


def test_both_checkers_have_the_same_least_torque(stored: dict[str, Any]) -> None:
    """As rational numbers, for a law with columns that rise and fall; below the reference too."""
    law = deepcopy(stored["gains"])
    for name, part in (("rotor_speed", 0.03), ("trim_effort", 0.2), ("proportional", 0.3)):
        law[name] = [round(x * (1 + part * (j % 3)), 6) for j, x in enumerate(law[name])]
    law["feedforward_limit"] = [0.002 * (j % 4) for j in range(len(law["wind"]) - 1)]
    law["overlap"] = 0.05
    read = read_text(json.dumps(law), "law")
    rotor = numbers.Rotor(loads(json.dumps(stored["model"])), loads(json.dumps(law)))
    for first in ("3.3", "8", "24"):
        one = sent.LeastTorque(Law.read(read), F(first))
        two = asked.Asked(rotor, fmpq(F(first).numerator, F(first).denominator))
        inside = 0
        for speed in (F(j, 20) for j in range(8, 40)):
            found = one.above(speed)
            again = two.torque(fmpq(speed.numerator, speed.denominator))
            assert found == F(int(again.p), int(again.q))
            inside += 0 < found < law["rated_torque"]
        assert inside > 2
