"""How fast a known wind may move: thresholds, and motions."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.certificates.claims.turbine.loop_claims import rate_range, wind_rate_claim
from takagi.models.laws.protocol import Measurement
from tests.certificates.conftest import cells_from
from tests.certificates.kinds.claims import resealed

PROVED, UNDECIDED = "PROVED", "UNDECIDED"
# Filter of a law that is not the default's [s], and the unit of the rates [m/s^2] that suit it.
FAST, UNIT = 3.2, 1 / 64


@pytest.fixture(scope="session")
def known(built: Any) -> dict[str, Any]:
    document = cells_from(built.document, 14.0)
    gains, loop = document["gains"], document["claims"][0]
    gains["wind_filter"] = FAST
    claim = wind_rate_claim(loop, gains["wind_filter"])
    return dict(resealed(document | {"claims": [loop, claim]}))


def verdict_on_rates(document: dict[str, Any]) -> str:
    return check_document(resealed(document)).claims[1].verdict.name


def uniform(document: dict[str, Any], rate: float, error: float) -> dict[str, Any]:
    changed = deepcopy(document)
    ends = [changed["gains"]["wind"][0], changed["gains"]["wind"][-1]]
    changed["claims"][1]["ranges"] = [
        {
            "wind": ends,
            "estimate_rate": [rate, rate],
            "schedule_rate": [rate, rate],
            "estimate_error": error,
        }
    ]
    return changed


@pytest.mark.slow
def test_the_default_law_bears_slow_winds_and_says_so(built: Any) -> None:
    """A filter of 12 s takes delta / 12 s: centimetres per second squared, in every wind cell."""
    loop, tau = built.document["claims"][0], built.document["gains"]["wind_filter"]
    claim = wind_rate_claim(loop, tau)
    assert claim is not None
    whole, upper = claim["ranges"]
    most = max(cell["wind_error"] for cell in loop["cells"]) / tau
    document = built.document | {"claims": [loop, claim]}

    assert tau == 12.0
    assert (whole["wind"][0], whole["wind"][-1]) == (3.0, 25.0)
    assert 0 < min(whole["estimate_rate"]) < max(whole["estimate_rate"]) <= most < 0.025
    # In the strongest wind a third of the class is left to the error of the estimate.
    full = [cell["wind_error"] for cell in loop["cells"] if cell["wind"][1] > upper["wind"][0]]
    assert upper["wind"][0] < 25.0
    assert min(full) / 4 < upper["estimate_error"] < min(full) / 3
    assert 0.6 < tau * min(upper["estimate_rate"]) / min(full) <= 0.7
    assert verdict_on_rates(document) == PROVED
    assert "wind filter of 12 s" in check_document(resealed(document)).claims[1].text


@pytest.mark.parametrize(("more", "verdict"), [(0.0, PROVED), (1e-7, UNDECIDED)])
def test_the_least_wind_error_is_the_threshold(
    known: dict[str, Any], more: float, verdict: str
) -> None:
    """eta + tau_f r <= min delta, with equality and 1e-7 m/s beyond."""
    loop, tau = known["claims"][0], known["gains"]["wind_filter"]
    error = min(cell["wind_error"] for cell in loop["cells"]) - tau * UNIT
    changed = uniform(known, UNIT, round(error + more, 9))

    assert verdict_on_rates(changed) == verdict


@pytest.mark.parametrize(("more", "verdict"), [(0.0, PROVED), (1e-6, UNDECIDED)])
def test_the_least_wind_rate_is_the_threshold(
    known: dict[str, Any], more: float, verdict: str
) -> None:
    """r <= min rho."""
    lowest_rate = min(cell["wind_rate"] for cell in known["claims"][0]["cells"])
    assert lowest_rate > 2 * UNIT

    assert verdict_on_rates(uniform(known, round(lowest_rate + more, 9), 0.0)) == verdict


def test_the_words_state_the_numbers(known: dict[str, Any]) -> None:
    """Overspeed, filter, range, error, and the winds from which each rate is allowed."""
    changed = uniform(known, UNIT, 0.0)
    changed["claims"][1]["ranges"][0] |= {
        "wind": [14.5, 15.0, 16.0, 16.5],
        "schedule_rate": [0.01, 0.01, 0.03, 0.03],
        "estimate_rate": [0.009, 0.009, 0.028, 0.028],
        "estimate_error": 0.0123,
    }
    gains, loop = changed["gains"], changed["claims"][0]
    fastest = max(gains["rotor_speed"]) + loop["peaks"]["speed_error"]
    over = 100 * (fastest / changed["model"]["rated_rotor_speed"] - 1)
    text = check_document(resealed(changed)).claims[1].text

    assert "wind filter of 3.2 s" in text
    assert f"overspeed at most {math.ceil(over * 100) / 100:g} %" in text
    assert "wind and estimate within 14.5 to 16.5 m/s, known to 0.0123 m/s" in text
    assert "at least 0.009 m/s^2 everywhere" in text
    # 0.009 + 0.019 (v - 15) = 0.02, rounded up.
    assert "0.02 m/s^2 from 15.579 m/s on" in text
    assert "0.05 m/s^2 from" not in text
    exact = check_document(resealed(uniform(known, UNIT, 0.0))).claims[1].text
    assert "known exactly: at least 0.0156 m/s^2 everywhere" in exact


def test_a_class_without_room_gives_no_claim(known: dict[str, Any]) -> None:
    """No filter, a class at rest: nothing is claimed; too large an error leaves rate 0."""
    loop = known["claims"][0]
    at_rest = loop | {"cells": [cell | {"wind_rate": 0.0} for cell in loop["cells"]]}

    assert wind_rate_claim(loop, 0.0) is None
    assert wind_rate_claim(at_rest, FAST) is None
    assert rate_range(loop["cells"], FAST, estimate_error=1.0).estimate_rate.max() == 0


def pushed(one: Range, tau: float, start: float, way: int) -> float:
    """Return the largest |w - v_s| - tau phi(v_s), the estimate always moving at r one way.

    Starts on the edge |w - v_s| = tau phi(v_s), where any excess shows at once; Heun's rule.
    """
    wind, r, phi = (np.array([float(x) for x in c]) for c in (one.wind, one.estimate, one.schedule))

    def motion(y: Any) -> Any:
        return np.array([way * np.interp(y[0], wind, r), (y[0] - y[1]) / tau])

    y, h, worst = np.array([start + way * tau * np.interp(start, wind, phi), start]), tau / 200, 0.0
    for _ in range(8):
        if not wind[0] <= y[0] <= wind[-1]:
            break
        worst = max(worst, way * (y[0] - y[1]) - tau * np.interp(y[1], wind, phi))
        first = motion(y)
        y = y + h / 2 * (first + motion(y + h * first))
    return float(worst)


@st.composite
def ranges(draw: st.DrawFn) -> Range:
    gaps = draw(st.lists(st.integers(2, 40), min_size=1, max_size=4))
    wind = [Fraction(10) + Fraction(sum(gaps[:i]), 20) for i in range(len(gaps) + 1)]
    rates = st.integers(1, 40).map(lambda n: Fraction(n, 20))
    phi = [draw(rates) for _ in wind]
    shares = st.integers(60, 130).map(lambda n: Fraction(n, 100))
    return Range(wind, [draw(shares) * p for p in phi], phi, Fraction(0))


@given(ranges(), st.sampled_from([Fraction(1, 20), Fraction(1, 2), Fraction(2)]))
@settings(max_examples=40)
def test_a_wind_that_pushes_stays_behind_what_is_proved(one: Range, tau: Fraction) -> None:
    """From the edge |w - v_s| = tau phi(v_s), an estimate at full rate does not get further."""
    if first_failure(filter_keeps_up(one, tau)):
        one = Range(one.wind, [rate / 2 for rate in one.estimate], one.schedule, one.error)
    if first_failure(filter_keeps_up(one, tau)):
        return
    starts = np.linspace(float(one.wind[0]), float(one.wind[-1]), 23)
    worst = max(pushed(one, float(tau), s, way) for s in starts for way in (1, -1))

    assert worst < 1e-4 * float(tau)


@pytest.mark.parametrize(
    ("wind", "phi", "start", "way"),
    [
        ([14.5, 15.0, 15.001, 16.0], [0.1, 0.1, 1.0, 1.0], 15.0005, -1),
        ([14.5, 15.0, 15.001, 16.0], [1.0, 1.0, 0.1, 0.1], 15.0005, 1),
        ([14.0, 15.0, 16.0], [0.2, 0.2, 2.0], 14.999, 1),
    ],
)
def test_a_wind_that_pushes_breaks_what_is_refused(
    wind: list[float], phi: list[float], start: float, way: int
) -> None:
    """r = phi: falling out of fast winds, rising into slow ones, rising where phi bends up."""
    nodes, rates = ([Fraction(str(x)) for x in column] for column in (wind, phi))
    one = Range(nodes, rates, rates, Fraction(0))

    assert first_failure(filter_keeps_up(one, Fraction(1, 10)))
    assert pushed(one, 0.1, start, way) > 1e-4


@pytest.mark.parametrize("tau", [0.05, 5.0])
def test_the_laws_own_filter_keeps_the_class_in_winds_at_full_rate(built: Any, tau: float) -> None:
    """Up and down through all winds at r, bang-bang, by the law's own state rate: inside."""
    loop, law = built.document["claims"][0], replace(built.law, wind_filter=tau)
    found = rate_range(loop["cells"], law.wind_filter)
    edges = np.array([cell["wind"][0] for cell in loop["cells"]][1:])
    error = np.array([cell["wind_error"] for cell in loop["cells"]])
    most = np.array([cell["wind_rate"] for cell in loop["cells"]])
    generator = np.random.default_rng(5)
    step, close = law.wind_filter / 20, 0.0
    for start in (3.4, 5.8, 10.3, 12.3, 13.0, 16.0):
        w, state, way = start, law.initial_state(start), 1
        for _ in range(1500):
            if generator.random() < 0.004 or not 3.0 < w < 25.0:
                way = -way
            w = min(max(w + way * step * np.interp(w, found.wind, found.estimate_rate), 3.0), 25.0)
            rate = float(law.state_rate(state, Measurement(1.2, 0.1, w))[1])
            v, k = float(state[1]), int(np.searchsorted(edges, state[1], side="right"))
            assert abs(rate) <= most[k] * (1 + 1e-9)
            assert abs(w - v) <= error[k]
            close = max(close, abs(rate) / most[k], abs(w - v) / error[k])
            state = state + step * np.array([0.0, rate])
    assert close > 0.95


@pytest.mark.parametrize("tau", [0.02, 0.3, 1.0, 5.0])
def test_the_candidate_proves_with_any_filter(built: Any, tau: float) -> None:
    """What is found in floating point holds exactly, and rates fall as the filter gets slower."""
    loop = built.document["claims"][0]
    found = rate_range(loop["cells"], tau)
    columns = (found.wind, found.estimate_rate, found.schedule_rate)
    wind, rate, phi = ([Fraction(str(x)) for x in column.tolist()] for column in columns)

    assert not first_failure(
        filter_keeps_up(Range(wind, rate, phi, Fraction(0)), Fraction(str(tau)))
    )
    assert found.estimate_rate.max() <= min(2.0, max(c["wind_error"] for c in loop["cells"]) / tau)
    # Next to nothing is lost between phi and r where phi is one line.
    flat = [a == b for a, b in pairwise(found.schedule_rate)]
    assert np.mean(found.estimate_rate / found.schedule_rate) > 0.8
    assert any(flat) or tau > 0.3
