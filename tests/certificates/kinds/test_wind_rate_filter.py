"""The law's filter against winds that push it, and the candidate that must stay below them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.certificates.claims.turbine.wind_rate_claim import rate_range, wind_rate_claim
from takagi.models.laws.protocol import Measurement


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


@pytest.mark.slow
def test_every_number_of_the_claim_counts(fast_built: Any) -> None:
    """Raised by 8 % where it binds: phi against the class, r against the filter, eta against it."""
    # A fast filter: with a slow one phi is below the class where that steps.
    loop, tau = fast_built.document["claims"][0], 0.05
    claim = wind_rate_claim(loop, tau)
    assert claim is not None
    whole = claim["ranges"][0]
    cells, found = loop["cells"], 0
    exact = {
        name: [Fraction(str(x)) for x in whole[name]] for name in whole if name[-5:] != "error"
    }
    lag = Fraction(str(tau))
    places = range(0, len(whole["wind"]), 4)
    for i in places:
        s = whole["wind"][i]
        phi = list(exact["schedule_rate"])
        phi[i] *= Fraction(108, 100)
        caps = [c["wind_rate"] for c in cells if c["wind"][0] <= s <= c["wind"][1]]
        assert phi[i] > Fraction(str(min(caps)))
        rate = list(exact["estimate_rate"])
        rate[i] *= Fraction(108, 100)
        raised = Range(exact["wind"], rate, exact["schedule_rate"], Fraction(0))
        found += bool(first_failure(filter_keeps_up(raised, lag)))
    # r is slack at some nodes next to a step of the class.
    assert found > 0.9 * len(places)
