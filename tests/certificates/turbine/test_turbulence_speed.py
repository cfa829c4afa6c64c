"""The rotor speed that turbulence seldom reaches: both checkers, forged files, torque by sampling.

The certificate is the first line of ``recorded/turbulence-speed.jsonl``: mean wind 5 m/s, class B.
"""

from __future__ import annotations

import json
import math
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from scipy.linalg import expm
from scipy.special import erfc

from takagi.certificates import CertificateError, check
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.overspeed import (
    rotor_torque as driving,
)
from takagi.certificates.checker.turbine.overspeed import (
    sent,
    speed_inputs,
)
from takagi.certificates.checker.turbine.overspeed import (
    speed_claim as verdict,
)
from takagi.certificates.claims.turbine import SpeedAsked, low_wind_claims, speed_claim
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers
from takagi.certificates.cross_check.turbine.overspeed import asked
from takagi.certificates.design import claim_summary
from takagi.cli.terminal import turbine_summary
from takagi.models import ModelError, nrel5mw
from takagi.models.turbine import rotor_torque
from takagi.reports.sections.turbine import verdict as report_verdict
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry, sealed, verdicts

F = Fraction
TURBINE = nrel5mw()


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("turbulence-speed"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


@pytest.fixture(scope="module")
def stated(stored: dict[str, Any]) -> speed_inputs.StatedSpeed:
    data = read_text(json.dumps(stored), "document")
    return speed_inputs.StatedSpeed.read(data["claims"][0], data, "claims[0]")


def test_both_checkers_prove_it(document: dict[str, Any]) -> None:
    assert verdicts(document) == ("PROVED", "PROVED")


def test_the_sentence_names_speed_wind_and_probability(document: dict[str, Any]) -> None:
    claim = document["claims"][0]
    said = check_document(sealed(document)).claims[0]
    over = 100 * claim["speed"] / document["model"]["rated_rotor_speed"]
    assert (
        f"reaches {claim['speed']:g} rad/s, {math.ceil(100 * over) / 100:g} % of its" in said.text
    )
    assert f"within 600 s is at most {claim['probability']:.5f}: in wind of mean 5" in said.text
    assert f"reaches {claim['highest_wind']:g} m/s with at most this probability" in said.text
    assert "whatever the wind estimate says" in said.text
    for phrase in ("no delay of the wake", "Gaussian", "rigid shaft, tower and blades"):
        assert any(phrase in one for one in said.assumes)


def test_an_end_by_the_estimate_is_in_the_sentence(document: dict[str, Any]) -> None:
    document["claims"][0]["least_estimate"] = 4.25
    document["claims"][0]["uncertainty"]["torque_excess"] = 1e-5
    text = check_document(sealed(document)).claims[0].text
    assert "until the wind estimate first falls below 4.25 m/s" in text
    assert "plus J times 0.00001 rad/s^2" in text


def scaled(part: str, name: str, factor: float) -> Change:
    """Return a change of a whole column or table."""

    def change(document: Any) -> None:
        owner = document[part]
        owner[name] = (factor * np.array(owner[name])).tolist()

    return change


def more_torque(document: Any) -> None:
    table = document["model"]["torque_surface"]
    table["coefficients"] = (1.05 * np.array(table["coefficients"])).tolist()


def other_filter(document: Any) -> None:
    """A slower filter, in claim and controller alike."""
    for one in (document["claims"][0], document["controller"]):
        one["measurement"]["speed_filter"] = 5.0


def reversed_pitch(document: Any) -> None:
    """The program then holds pitch at 0, the greatest; the rotor's torque is bounded for 0.1 on.

    With pitch at 0 the rotor may be driven to 1.4 rad/s, with 0.1 rad it is not to 1.3.
    """
    document["claims"][0]["speed"] = 1.3
    for part in ("model", "gains"):
        document[part] |= {"pitch_min": 0.1, "pitch_max": 0.0}


def everywhere(*path: Any, value: Any) -> Change:
    """Return a change of the filters, in claim and controller alike."""

    def change(document: Any) -> None:
        for one in (document["claims"][0], document["controller"]):
            entry("measurement", *path, value=value)(one)

    return change


CLAIM = ("claims", 0)
FALSE = {
    "a smaller speed": entry(*CLAIM, "speed", factor=0.999),
    "a smaller probability": entry(*CLAIM, "probability", factor=0.97),
    "a longer time": entry(*CLAIM, "horizon", factor=1.05),
    "a wider wind": entry(*CLAIM, "wind", "deviation", factor=1.01),
    "a faster wind": entry(*CLAIM, "wind", "rate", factor=1.05),
    "a higher mean wind": entry(*CLAIM, "wind", "mean", factor=1.01),
    "a mean wind below the tables": entry(*CLAIM, "wind", "mean", value=2.9),
    "a smaller highest wind": entry(*CLAIM, "highest_wind", factor=0.99),
    "a greater highest wind": entry(*CLAIM, "highest_wind", factor=1.01),
    "a highest wind below the mean": entry(*CLAIM, "highest_wind", value=4.0),
    "a highest wind that may be met by a reversed one": entry(*CLAIM, "highest_wind", value=10.5),
    "a deviation beyond the highest wind": entry(*CLAIM, "wind", "deviation", value=4.0),
    "a window that is too short": entry(*CLAIM, "window", factor=0.1),
    "a lighter rotor": entry(*CLAIM, "uncertainty", "inertia", 0, factor=0.5),
    "more torque than the table's": entry(*CLAIM, "uncertainty", "torque_excess", value=0.002),
    "an estimate above the mean wind": entry(*CLAIM, "least_estimate", value=5.5),
    "an estimate above the tables": entry(*CLAIM, "least_estimate", value=30.0),
    "a start above the speed": scaled("gains", "rotor_speed", 2.1),
    "a rotor with more torque": more_torque,
    "a slower generator": entry("model", "torque_rate_limit", factor=0.2),
    "a smaller generator": entry("gains", "rated_torque", factor=0.8),
    "a wider limit of the integral": entry("gains", "integral_limit", factor=1.5),
    "more feed-forward": scaled("gains", "feedforward_limit", 8.0),
    "smaller gains": scaled("gains", "proportional", 0.9),
    "greater reserves": scaled("gains", "trim_effort", 1.01),
    "a slower filter of the speed": other_filter,
}
MALFORMED = {
    "a speed of 0": entry(*CLAIM, "speed", value=0.0),
    "a window of 0": entry(*CLAIM, "window", value=0.0),
    "a window as wide as the speed": entry(*CLAIM, "window", value=2.0),
    "a window of the speed": entry(*CLAIM, "window", value=1.437),
    "a band-stop that passes less than nothing": everywhere("torsion_filter", "passed", value=-0.1),
    "a band-stop that passes more": everywhere("torsion_filter", "passed", value=1.1),
    "a band-stop of no frequency": everywhere("torsion_filter", "frequency", value=0.0),
    "a filter of the speed that stands still": everywhere("speed_filter", value=0.0),
    "a probability of 1": entry(*CLAIM, "probability", value=1.0),
    "no probability": lambda d: d["claims"][0].pop("probability"),
    "a negative time": entry(*CLAIM, "horizon", factor=-1),
    "a wind that stands still": entry(*CLAIM, "wind", "deviation", value=0.0),
    "a rate of 0": entry(*CLAIM, "wind", "rate", value=0.0),
    "an inertia of 0": entry(*CLAIM, "uncertainty", "inertia", 0, value=0.0),
    "inertia in the wrong order": entry(*CLAIM, "uncertainty", "inertia", value=[1.1, 0.9]),
    "less torque than the table's": entry(*CLAIM, "uncertainty", "torque_excess", value=-0.01),
    "no excess": lambda d: d["claims"][0]["uncertainty"].pop("torque_excess"),
    "an estimate of 0": entry(*CLAIM, "least_estimate", value=0.0),
    "another filter than the controller's": entry(*CLAIM, "measurement", "speed_filter", value=99),
    "a band-stop that passes more than all": entry(
        *CLAIM, "measurement", "torsion_filter", "passed", value=1.5
    ),
    "other pitch limits": entry("gains", "pitch_min", value=0.01),
    "pitch limits in the wrong order": reversed_pitch,
    "no wind filter": entry("gains", "wind_filter", value=0.0),
}


@pytest.mark.parametrize("name", FALSE)
def test_a_false_claim_is_undecided(document: dict[str, Any], name: str) -> None:
    FALSE[name](document)
    assert verdicts(document) == ("UNDECIDED", "UNDECIDED")


@pytest.mark.parametrize("name", MALFORMED)
def test_a_malformed_claim_is_refused(document: dict[str, Any], name: str) -> None:
    MALFORMED[name](document)
    assert verdicts(document) == ("refused", "refused")


def test_a_gain_file_with_another_filter_is_refused(
    document: dict[str, Any], tmp_path: Path
) -> None:
    """Also where the certificate has no ``controller``; another observer does not matter then."""
    controller = document.pop("controller")
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(sealed(document)), encoding="utf-8")
    controller["measurement"]["speed_filter"] = 20.0
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    with pytest.raises(CertificateError, match="measurement.speed_filter is not the gain file's"):
        check(certificate, gains=gains)


@pytest.mark.parametrize(("limit", "refused"), [("torque_rate", True), ("pitch_rate", False)])
def test_a_gain_file_with_another_limit_of_the_torques_rate_is_refused(
    document: dict[str, Any], tmp_path: Path, limit: str, refused: bool
) -> None:
    """The claim has the limit of the generator, and not the one of pitch; without ``controller``
    nothing else compares it."""
    controller, model = document.pop("controller"), document["model"]
    limits = {name: model[f"{name}_limit"] for name in ("torque_rate", "pitch_rate")}
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(sealed(document)), encoding="utf-8")
    for factor in (1.0, 0.5):
        file = {"law": document["gains"], **controller, "limits": limits | {}}
        file["limits"][limit] *= factor
        gains.write_text(json.dumps(file), encoding="utf-8")
        if refused and factor != 1:
            with pytest.raises(CertificateError, match=f"limits.{limit} is not the certificate's"):
                check(certificate, gains=gains)
        else:
            assert check(certificate, gains=gains).verdict.name == "PROVED"


# Each condition alone, from both sides, in both checkers: all others hold.


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
        entry(*CLAIM, "uncertainty", "torque_excess", value=1e-3),
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


# The parts, by other ways.


def test_the_probability_is_rices(stated: speed_inputs.StatedSpeed) -> None:
    """Against erfc of scipy: the bound is above it by the bound of erfc, 5 % here, alone."""
    wind = stated.wind
    for highest in (7.0, 8.0, 8.7):
        z = (highest - 5) / float(wind.deviation)
        crossings = 600 * float(wind.rate / wind.deviation) / math.pi
        exact = erfc(z / math.sqrt(2)) + crossings * math.exp(-(z**2) / 2)
        bound = verdict.probability_bound(wind, F(str(highest)), F(600))
        assert bound is not None
        assert 1 <= float(bound) / exact < 1.01
    assert verdict.probability_bound(wind, F("5.69"), F(600)) is None


def test_the_delay_is_the_filters(stated: speed_inputs.StatedSpeed) -> None:
    """The step response of docs/running-loop.md's filters, exact at steps of 1 ms, is below 1, and
    the integral of what it lacks is the delay."""
    assert stated.stop is not None
    c, w, passed = map(float, (stated.corner, *stated.stop))
    left = 2 * (1 - passed) * c
    # States y_1, y_2, omega_m, and the speed, which is 1.
    A = np.array([[-w, 0, 0, w], [w, -w, 0, 0], [-left, left, -c, c], [0, 0, 0, 0]])
    flow, state, lacks = np.asarray(expm(A * 1e-3)), np.array([0.0, 0.0, 0.0, 1.0]), [1.0]
    for _ in range(5000):
        state = flow @ state
        lacks.append(1 - float(state[2]))
    assert min(lacks) >= -1e-12
    assert np.trapezoid(lacks, dx=1e-3) == pytest.approx(float(stated.delay), rel=1e-4)


def least_sampled(law: dict[str, Any], measured: float, first: float) -> float:
    """Return the law's least torque over many schedule winds, integrals and feed-forwards."""
    nodes = np.array(law["wind"])
    v = np.unique(np.concatenate([np.linspace(max(first, nodes[0]), nodes[-1], 20001), nodes]))
    v = v[v >= first]
    k = np.clip(np.searchsorted(nodes, v, side="right") - 1, 0, len(nodes) - 2)
    omega, q, gamma = (
        np.interp(v, nodes, law[name]) for name in ("rotor_speed", "trim_effort", "proportional")
    )
    fed = np.maximum(np.array(law["feedforward_limit"])[k], 0)
    U = q + gamma * (measured - omega - law["integral_limit"])
    eps = law["overlap"]
    held = (np.clip(-U, -eps, eps) + eps) ** 2 / (4 * eps) + np.maximum(-U - eps, 0)
    asked = law["rated_torque"] - law["effort_torque"] * (held + fed)
    return float(np.clip(asked, 0, law["rated_torque"]).min())


@pytest.mark.parametrize("first", [3.0, 4.25, 9.0])
@pytest.mark.parametrize("measured", [0.9, 1.3, 1.45])
def test_the_least_torque_is_that_of_sampled_schedule_winds(
    stored: dict[str, Any], stated: speed_inputs.StatedSpeed, first: float, measured: float
) -> None:
    """A lower bound, and within 5 % of rated torque of the least sample."""
    law = stored["gains"]
    found = float(sent.LeastTorque(stated.law, F(str(first))).above(F(str(measured))))
    sampled = least_sampled(law, measured, first)
    assert found <= sampled + 1e-6
    assert sampled - found < 0.05 * law["rated_torque"]


@pytest.mark.parametrize(("slow", "fast"), [(1.4, 1.4), (1.2, 1.45)])
def test_the_rotor_torque_is_that_of_sampled_winds(
    stated: speed_inputs.StatedSpeed, slow: float, fast: float
) -> None:
    """An upper bound, within 15 % of what the model gives at sampled speeds, winds, pitches."""
    random, n = np.random.default_rng(3), 40000
    speed, v = random.uniform(slow, fast, n), random.uniform(0.5, 8.7, n)
    pitch = random.uniform(0, 0.5, n) * random.integers(0, 2, n)
    v[:50], pitch[:50] = 8.7, 0.0
    sampled = (rotor_torque(TURBINE, speed, pitch, v, clip=True) / TURBINE.inertia).max()
    found = float(driving.greatest(stated.plant, (F(str(slow)), F(str(fast))), F("8.7")))
    assert sampled <= found < 1.15 * sampled
    assert driving.greatest_at_any_speed(stated.plant, F("8.7")) > found


def test_an_estimate_that_is_stuck_does_not_break_the_bound(
    stored: dict[str, Any], stated: speed_inputs.StatedSpeed
) -> None:
    """The loop of docs/turbulence-speed.md by Euler: estimate at 3 m/s, wind at its highest.

    The integral is held at its limit, the worst value.  The speed stays below the bound, and comes
    within 5 % of it: the bound is nearly sharp for a wind estimate that may be anything.
    """
    law, claim = stored["gains"], stored["claims"][0]
    nodes = np.array(law["wind"])
    v, dt = claim["highest_wind"], 0.02
    w, passed = claim["measurement"]["torsion_filter"].values()
    c, kappa = claim["measurement"]["speed_filter"], 1 / 0.9
    speed = measured = y1 = y2 = float(np.interp(5.0, nodes, law["rotor_speed"]))
    vs, torque, largest = 5.0, 0.0, 0.0
    for _ in range(6000):
        vs += dt * (3.0 - vs) / law["wind_filter"]
        omega, q, gamma = (
            np.interp(vs, nodes, law[name])
            for name in ("rotor_speed", "trim_effort", "proportional")
        )
        U = q + gamma * (measured - omega - law["integral_limit"])
        asked = law["rated_torque"] - law["effort_torque"] * max(-U, 0.0)
        moved = np.clip((np.clip(asked, 0, law["rated_torque"]) - torque) / dt, -15000, 15000)
        torque += dt * moved
        driving = float(rotor_torque(TURBINE, speed, 0.0, v, clip=True))
        rate = kappa * (driving - 97 * torque) / TURBINE.inertia
        measured += dt * c * (speed - 2 * (1 - passed) * (y1 - y2) - measured)
        y1, y2 = y1 + dt * w * (speed - y1), y2 + dt * w * (y1 - y2)
        speed += dt * rate
        largest = max(largest, speed)
    assert 0.95 * claim["speed"] < largest < claim["speed"]


@pytest.mark.slow
def test_both_checkers_turn_at_the_same_speed(
    document: dict[str, Any], stated: speed_inputs.StatedSpeed
) -> None:
    """By halving in the first checker; the second turns within 0.0002 rad/s of that."""
    low, high = stated.speed * F(99, 100), stated.speed
    while high - low > F(1, 10000):
        middle = (low + high) / 2
        low, high = (
            (low, middle) if verdict.is_held(replace(stated, speed=middle)) else (middle, high)
        )
    for away, answer in ((F(1, 10000), "PROVED"), (F(-2, 10000), "UNDECIDED")):
        document["claims"][0]["speed"] = round(float(high + away), 6)
        assert verdicts(document) == (answer, answer)


def test_the_wind_that_is_claimed_keeps_its_sign(document: dict[str, Any]) -> None:
    """Up to twice the mean of 5 m/s; above that |y| < b leaves winds below zero."""
    claim = document["claims"][0]
    claim["speed"] = 2.2
    for highest, answer in ((9.999, "PROVED"), (10.0, "PROVED"), (10.001, "UNDECIDED")):
        claim["highest_wind"] = highest
        assert verdicts(document) == (answer, answer)


def test_the_search_says_why_it_finds_none(stored: dict[str, Any]) -> None:
    claims, why = speed_claim(
        stored["model"],
        stored["gains"],
        stored["controller"],
        [0.9, 1.1],
        SpeedAsked(
            mean=5.0,
            deviation=2.0,
            rate=0.05,
            probability=1e-5,
            horizon=600.0,
            least_estimate=3.0,
        ),
    )
    assert claims == []
    assert why == {"turbulence-speed": "not claimed: no wind is rare enough"}


ASKED = SpeedAsked(
    mean=5.0, deviation=0.7, rate=0.05, probability=1e-3, horizon=600.0, least_estimate=3.0
)


@pytest.mark.parametrize(
    ("part", "name", "words"),
    [
        ("controller", "measurement", "the gain file has no low-pass on the measured speed"),
        ("gains", "wind_filter", "the law has no filter of the wind estimate"),
    ],
)
def test_a_law_without_a_filter_has_no_claim(
    document: dict[str, Any], part: str, name: str, words: str
) -> None:
    """Such a law may be certified with ``--turbulence``: the provenance says why."""
    if part == "controller":
        del document[part][name]
    else:
        document[part][name] = 0.0
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    assert speed_claim(*given, ASKED) == ([], {"turbulence-speed": f"not claimed: {words}"})


@pytest.mark.parametrize("change", [{"probability": 1.0}, {"horizon": -1.0}, {"excess": -0.1}])
def test_what_no_claim_can_say_is_misuse(stored: dict[str, Any], change: dict[str, float]) -> None:
    given = stored["model"], stored["gains"], stored["controller"], [0.9, 1.1]
    with pytest.raises(ModelError, match="no claim of a speed in turbulence can be made: claim"):
        speed_claim(*given, replace(ASKED, **change))


@pytest.mark.slow
def test_a_design_s_claim_for_low_wind_is_proved_and_told(stored: dict[str, Any]) -> None:
    parts = stored["model"], stored["gains"], stored["controller"]
    told: list[str] = []
    claims, left_out = low_wind_claims(*parts, [0.9, 1.1], "B", told.append)
    assert (told, left_out) == (["rotor speed in turbulence, at 5 m/s"], {})
    whole = stored | {"claims": claims}
    assert verdicts(deepcopy(whole)) == ("PROVED", "PROVED")
    design: Any = SimpleNamespace(document=whole, checked=check_document(sealed(deepcopy(whole))))
    (found,) = claim_summary.seldom_reached(design)
    assert (found.wind, found.probability, found.horizon) == (5.0, 1e-3, 600.0)
    # docs/turbulence-speed.md
    assert found.share == pytest.approx(1.0481, abs=5e-4)
    told_of = turbine_summary._low_wind(design)
    assert "mean 5 m/s the nonlinear loop's rotor reaches 104.9 % of rated" in told_of
    assert report_verdict._in_low_wind(design)[0][:2] == (
        "Turbulence at 5 m/s, nonlinear loop",
        "\u2264 0.001",
    )


@pytest.mark.slow
def test_a_speed_far_above_rated_is_not_claimed(stored: dict[str, Any]) -> None:
    """An inertia of 15 % of nominal and class A."""
    parts = stored["model"], stored["gains"], stored["controller"]
    claims, left_out = low_wind_claims(*parts, [0.15, 1.1], "A")
    assert claims == []
    assert "% of rated" in left_out["turbulence-speed"]
