"""The turbine's judge: silent about the certificate as designed, loud about false claims."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.certificates.kinds.claims import Data

campaign: Any = import_module("mutations")
damage: Any = import_module("damage")
judge: Any = import_module("turbine_judge")
reading: Any = import_module("turbine_loop")
Change = Callable[[Data], None]
LOOP, WIND_RATE, ACTUATORS, RUNNING = range(4)


@pytest.fixture(autouse=True, scope="module")
def _whole_campaign(reduced: bool) -> None:
    if reduced:
        pytest.skip("a minute: without TAKAGI_REDUCED")


def why(document: Data, change: Change) -> str:
    changed = deepcopy(document)
    change(changed)
    found: str = judge.why_false(changed, random.Random(1))
    return found


def why_alone(document: Data, change: Change, place: int) -> str:
    changed = deepcopy(document)
    change(changed)
    claim, loop = changed["claims"][place], reading.Loop(changed, changed["claims"][LOOP])
    found: str = judge.KINDS[claim["kind"]](loop, claim, np.random.default_rng(1))
    return found


def times(value: Any, factor: float) -> Any:
    return damage.Number(repr(float(value) * factor))


def every(key: str, factor: float, claim: int = LOOP) -> Change:
    def change(document: Data) -> None:
        for cell in document["claims"][claim]["cells"]:
            cell[key] = times(cell[key], factor)

    return change


def entry(*place: Any, factor: float) -> Change:
    def change(document: Data) -> None:
        owner: Any = document
        for key in place[:-1]:
            owner = owner[key]
        owner[place[-1]] = times(owner[place[-1]], factor)

    return change


def all_rates(key: str, factor: float) -> Change:
    def change(document: Data) -> None:
        for one in document["claims"][WIND_RATE]["ranges"]:
            one[key] = [times(value, factor) for value in one[key]]

    return change


def estimate_error(factor: float) -> Change:
    return entry("claims", WIND_RATE, "ranges", 1, "estimate_error", factor=factor)


def slower_wind_and_faster_filter(document: Data) -> None:
    """Lower r too: it is fitted to tau_f, so that a faster filter alone need not keep to phi."""
    all_rates("estimate_rate", 0.8)(document)
    entry("gains", "wind_filter", factor=0.9)(document)


def narrowed(key: str, end: int) -> Change:
    def change(document: Data) -> None:
        for cell in document["claims"][0]["cells"]:
            mine, other = (Fraction(cell[key][i]) for i in (end, 1 - end))
            cell[key][end] = damage.Number(repr(float(mine + (other - mine) / 4)))

    return change


def test_the_certificate_has_the_claims_that_are_judged(document: Data) -> None:
    kinds = ["coherent-loop", "wind-rate", "bumpless", "running-loop"]

    assert [claim["kind"] for claim in document["claims"]] == kinds


def test_nothing_is_found_against_the_certificate(document: Data) -> None:
    assert judge.why_false(document, random.Random(1)) == ""


def test_it_is_the_set_that_such_winds_leave(document: Data) -> None:
    """From 4 m/s on: below, a wind so far off is beyond the surface's tip-speed ratios first."""

    def change(document: Data) -> None:
        for cell in document["claims"][LOOP]["cells"]:
            if float(cell["wind"][0]) >= 4:
                cell["wind_error"] = times(cell["wind_error"], 2.0)

    assert why(document, change).startswith("V' + a (V - 1)")


def test_the_surface_s_end_is_seen(document: Data) -> None:
    """Half a metre per second off at 3.25 m/s leads beyond the surface's last tip-speed ratio."""
    place = ("claims", LOOP, "cells", 1, "wind_error")

    assert why(document, entry(*place, factor=5.0)).startswith(("the surface ends", "wind_gain"))


@pytest.mark.parametrize(
    ("change", "said", "place"),
    [
        (all_rates("estimate_rate", 1.01), "the schedule wind is faster than stated", WIND_RATE),
        (all_rates("schedule_rate", 0.99), "the schedule wind is faster than stated", WIND_RATE),
        (
            all_rates("schedule_rate", 1.01),
            "the schedule wind is faster than the claim allows",
            WIND_RATE,
        ),
        (estimate_error(1.02), "the schedule wind is further off", WIND_RATE),
        (entry("gains", "wind_filter", factor=1.1), "the schedule wind is", WIND_RATE),
        (every("pitch_rate", 0.9, ACTUATORS), "pitch_rate is", ACTUATORS),
        (every("signal_rate", 0.9, ACTUATORS), "signal_rate is", ACTUATORS),
        (every("torque_rate", 0.7, ACTUATORS), "torque_rate is", ACTUATORS),
    ],
)
def test_a_claim_on_the_loop_made_larger_is_seen(
    document: Data, change: Change, said: str, place: int
) -> None:
    assert why_alone(document, change, place).startswith(said)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "place"),
    [
        (all_rates("estimate_rate", 0.99), WIND_RATE),
        (estimate_error(0.5), WIND_RATE),
        (slower_wind_and_faster_filter, WIND_RATE),
        (every("pitch_rate", 1.1, ACTUATORS), ACTUATORS),
        (every("signal_rate", 1.1, ACTUATORS), ACTUATORS),
        (every("torque_rate", 1.1, ACTUATORS), ACTUATORS),
    ],
)
def test_a_claim_on_the_loop_made_smaller_is_still_true(
    document: Data, change: Change, place: int
) -> None:
    assert why_alone(document, change, place) == ""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (every("decay_rate", 2.0), "decay is slower"),
        (every("multiplier", 20.0), "V' + a (V - 1)"),
        (every("residual", 0.7), "residual"),
        (every("wind_gain", 0.7), "wind_gain"),
        (every("inertia_gain", 0.9), "inertia_gain"),
        (every("effectiveness_slope", 0.9), "effectiveness_slope"),
        (every("reference_slope", 0.7), "reference_slope"),
        (every("lag_disturbance", 0.7), "lag_disturbance"),
        (entry("claims", 0, "settling", "decay_rate", factor=3.0), "common decay is slower"),
        (entry("claims", 0, "peaks", "speed_error", factor=0.99), "speed_error reaches"),
        (entry("gains", "integral_limit", factor=0.1), "integral reaches"),
        (entry("model", "torque_constant", factor=1.1), ""),
        (entry("model", "generator_inertia", factor=0.5), ""),
    ],
)
def test_a_false_number_is_seen(document: Data, change: Change, said: str) -> None:
    found = why(document, change)

    assert found
    assert found.startswith(said)


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("key", ["stiffness", "loop_gain", "lag_gain", "share_gain"])
def test_a_range_that_is_too_narrow_is_seen(document: Data, key: str, end: int) -> None:
    assert why(document, narrowed(key, end)).startswith(key)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["wind_error", "wind_rate", "decay_rate"])
def test_a_smaller_class_is_still_true(document: Data, key: str) -> None:
    assert why_alone(document, every(key, 0.9), LOOP) == ""


@pytest.mark.parametrize("key", ["wind_error", "wind_rate"])
def test_a_smaller_class_bears_less_than_the_filter_may_do(document: Data, key: str) -> None:
    """The claim about the wind's rate rests on the class that it was made for."""
    assert why_alone(document, every(key, 0.9), WIND_RATE).startswith("the schedule wind is")


@pytest.mark.slow
def test_a_mutant_that_says_less_is_weaker_by_judgement(document: Data, tmp_path: Path) -> None:
    """A slower decay, on which no other claim rests."""
    changed = deepcopy(document)
    place = ("claims", 0, "cells", 40, "decay_rate")
    entry(*place, factor=0.5)(changed)
    path = tmp_path / "certificate.json"

    assert campaign.judged(document, changed, place, path, random.Random(1)) == ("weaker", "")


@pytest.mark.slow
def test_a_proved_mutant_that_is_false_is_called_so(
    document: Data, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign, "said_of", lambda *_: campaign.Verdict.PROVED)
    path = tmp_path / "certificate.json"
    path.write_text(damage.text_of(document), encoding="utf-8")
    changed = deepcopy(document)
    every("wind_error", 20.0)(changed)
    place = ("claims", 0, "cells", 3, "wind_error")

    outcome, _ = campaign.judged(document, changed, place, path, random.Random(1))

    assert outcome == "false"


def test_the_wake_adds_effectiveness_up_to_the_frozen_one(document: Data) -> None:
    """-d(T_r/J + Delta)/dbeta by differences is the larger of surface's and frozen wake's."""
    loop = reading.Loop(document, document["claims"][0])
    k = np.arange(len(loop.cells))
    at = loop.at(k, np.column_stack([np.full(len(k), 0.3), np.full(len(k), 0.5), np.ones(len(k))]))
    trim = loop.law["pitch_min"]
    trim += reading.psi(at.table["trim_effort"], loop.law["overlap"]) / at.table["effectiveness"]
    pitch, step = trim + 0.03, 1e-5
    slope = -(loop.added(at, pitch + step) - loop.added(at, pitch - step)) / (2 * step)
    speed = at.table["rotor_speed"]
    own = -loop.c * at.wind**2 * loop.cq(speed, pitch, at.wind, (0, 1))
    limit = np.maximum(own, at.table["effectiveness_limit"])

    assert np.all(loop.added(at, trim) == 0)
    assert np.allclose(own + slope, limit, rtol=1e-2, atol=1e-3)


@pytest.mark.parametrize(
    "shown",
    [
        "overspeed at most 1 %",
        "winds 2 to 25 m/s in 70 cells",
        "inertia 0.8 to 1.1 of nominal",
        "|v - v_s| up to 1 to 2 m/s",
        "settles at no less than 1 1/s in one function, up to 2 1/s by wind cell",
    ],
)
def test_what_is_shown_is_compared(document: Data, shown: str) -> None:
    assert judge.why_shown_false(document, [shown]) != ""


@pytest.mark.slow
def test_the_words_that_are_compared_are_the_checker_s(document: Data, tmp_path: Path) -> None:
    """What the checker shows passes, and does not with one of its numbers changed."""
    path = tmp_path / "certificate.json"
    path.write_text(damage.text_of(document), encoding="utf-8")
    texts = [claim.text for claim in campaign.check(path).claims]

    assert judge.why_shown_false(document, texts) == ""
    for claim, words, number in (
        (LOOP, r"overspeed at most ", "1"),
        (LOOP, r"winds ", "2"),
        (LOOP, r"inertia ", "0.5"),
        (LOOP, r"v_s\| up to ", "9"),
        (LOOP, r"v_s'\| up to ", "9"),
        (LOOP, r"no less than ", "9"),
        (LOOP, r"for all winds, up to ", "9"),
        (WIND_RATE, r"wind filter of ", "0.04"),
        (WIND_RATE, r"overspeed at most ", "1"),
        (WIND_RATE, r"estimate within ", "2.9"),
        (WIND_RATE, r"known to ", "0.05"),
        (WIND_RATE, r"at least ", "0.01"),
        (ACTUATORS, r"pitch moves at most at ", "0.13"),
        (ACTUATORS, r"rad/s, and in ", "71"),
        (ACTUATORS, r"drive's limit of ", "0.1"),
        (ACTUATORS, r"nodes, at most at ", "14000"),
        (ACTUATORS, r"rate, in ", "2"),
        (ACTUATORS, r"v_s''\| is at most ", "9"),
        (ACTUATORS, r"\), and in ", "71"),
        (ACTUATORS, r"turbine's limit of ", "9"),
        (ACTUATORS, r"steps by at most ", "9"),
        (RUNNING, r"a rate of ", "0.005"),
        (RUNNING, r"constant wind from ", "2.9"),
    ):
        changed = re.sub(f"({words})\\S+", rf"\g<1>{number}", texts[claim], count=1)
        assert changed != texts[claim], words
        said = [changed if place == claim else "" for place in range(4)]
        assert judge.why_shown_false(document, said) != "", words
