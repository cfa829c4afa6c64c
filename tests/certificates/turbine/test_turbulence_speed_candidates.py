"""``turbulence-speed``: the search, what a design claims, and how it is told."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import SpeedAsked, low_wind_claims, speed_claim
from takagi.certificates.design import claim_summary
from takagi.cli.terminal import turbine_summary
from takagi.models import ModelError, nrel5mw
from takagi.reports.sections.turbine import verdict as report_verdict
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdicts

F = Fraction
TURBINE = nrel5mw()


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("turbulence-speed"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


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
