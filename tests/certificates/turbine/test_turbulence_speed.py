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
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import erfc

from takagi.certificates import CertificateError, check
from takagi.certificates.checker import check_document, read_text
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
from takagi.models import nrel5mw
from takagi.models.turbine import rotor_torque
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry, everywhere, sealed, verdicts

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
