"""``--moving-wind-above-rated``: the ranges that are searched, what is kept, and what is told.

The certificate is the first line of ``recorded/schedule-rate.jsonl``: three cells of the default
law of the NREL 5-MW turbine, with schedule winds from 17.034 to 18.5276 m/s.
"""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates import DesignSettings
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel import refusal
from takagi.certificates.claims.turbine import loop_claims, schedule_claims
from takagi.certificates.claims.turbine.scheduled_loop import schedule_ranges, schedule_rate_claim
from takagi.certificates.design import claim_summary
from takagi.certificates.design.given import turbine_law
from takagi.certificates.document import provenance
from takagi.cli.main import main
from takagi.cli.terminal import turbine_summary
from takagi.reports.sections.turbine import verdict as report_verdict
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdicts

F = Fraction
INERTIA = [0.9, 1.1]
Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("schedule-rate"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


def parts(document: dict[str, Any]) -> tuple[Any, Any, Any, list[float]]:
    return document["model"], document["gains"], document["controller"], INERTIA


# The ranges.


def test_the_ranges_of_the_default_law_are_those_of_the_page(document: dict[str, Any]) -> None:
    """docs/schedule-rate.md, the table of the results."""
    found = [
        (float(one.low), float(one.high), one.rate)
        for one in schedule_ranges.schedule_ranges(document["gains"])
    ]
    assert found == [
        (12.1509, 14.0467, 0.008),
        (13.0509, 16.0382, 0.016),
        (15.0425, 24.0042, 0.03),
    ]


def test_a_range_without_an_interval_of_the_tables_is_left_out(document: dict[str, Any]) -> None:
    """Tables that end at 14.5446 m/s have two nodes of the second range, and none of the third."""
    gains = document["gains"]
    kept = sum(v <= 14.5446 for v in gains["wind"])
    gains["wind"], gains["trim_effort"] = gains["wind"][:kept], gains["trim_effort"][:kept]
    found = schedule_ranges.schedule_ranges(gains)
    assert [float(one.high) for one in found] == [14.0467, 14.5446]


def test_a_law_without_winds_above_rated_has_no_such_claim(document: dict[str, Any]) -> None:
    gains = document["gains"]
    kept = sum(v <= 12.1 for v in gains["wind"])
    gains["wind"], gains["trim_effort"] = gains["wind"][:kept], gains["trim_effort"][:kept]
    words = "the law's tables have no interval far enough above rated wind"
    assert schedule_claims(*parts(document)) == ([], {"schedule-rate": f"not claimed: {words}"})
    gains["trim_effort"] = [-1.0 for _ in gains["wind"]]
    _, why = schedule_claims(*parts(document))
    assert why["schedule-rate"].endswith(
        "pitch has the whole effort at no wind of the law's tables"
    )


# What is kept.


def found_above(document: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any, Any]:
    """Let the search find the recorded claim in the last range, and nothing in the others."""
    claim = document["claims"][0]

    def searched(*given: Any) -> Any:
        within, rate, tell = given[4:]
        tell("attempt 1 of 10 at most")
        if rate < 0.03:
            raise refusal.Refused("no quadratic function was found about the schedule wind")
        assert within == (F("15.0425"), F("24.0042"))
        return claim

    monkeypatch.setattr(schedule_rate_claim, "schedule_rate_claim", searched)
    told: list[str] = []
    claims, left_out = schedule_claims(*parts(document), told.append)
    return claims, left_out, told


def test_what_was_found_is_kept_when_a_range_fails(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    claims, left_out, told = found_above(document, monkeypatch)
    assert claims == document["claims"] and verdicts(document) == ("PROVED", "PROVED")
    words = "not claimed: no quadratic function was found about the schedule wind"
    assert left_out == {
        "schedule-rate, 12.1509 to 14.0467 m/s at 0.008 m/s^2": words,
        "schedule-rate, 13.0509 to 16.0382 m/s at 0.016 m/s^2": words,
    }
    assert told == [f"moving wind, range {k} of 3: attempt 1 of 10 at most" for k in (1, 2, 3)]


def test_a_claim_that_the_checker_does_not_prove_is_left_out(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    document["claims"][0]["cells"][1]["decay_rate"] *= 3
    claims, left_out, _ = found_above(document, monkeypatch)
    assert claims == []
    why = left_out["schedule-rate, 15.0425 to 24.0042 m/s at 0.03 m/s^2"]
    assert why.startswith("not claimed: not proved: schedule wind 17.5318 to 18.0297 m/s")


@pytest.mark.parametrize("broken", ["numbers", "singular"])
def test_a_solver_that_breaks_down_is_an_answer(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch, broken: str
) -> None:
    """With functions that are no numbers, or have no inverse."""
    entry = np.nan if broken == "numbers" else 0.0

    def functions(loops: Any, places: Any, count: int, decay: float) -> Any:
        return 2.0, [np.full((10, 10), entry) for _ in range(count)]

    monkeypatch.setattr(schedule_rate_claim, "functions", functions)
    claims, why = loop_claims.schedule_claim(
        *parts(document), within=(F("18.0297"), F("18.5276")), rate=0.01
    )
    assert claims == []
    assert why["schedule-rate"].endswith("no quadratic function was found about the schedule wind")


def test_a_gain_file_without_an_observer_is_an_answer(document: dict[str, Any]) -> None:
    claims, why = schedule_claims(document["model"], document["gains"], {}, INERTIA)
    assert claims == [] and len(why) == 3
    assert all("the gain file has no observer" in words for words in why.values())


@pytest.mark.slow
def test_the_search_keeps_one_range_and_says_why_another_fails(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One interval of the tables at a low rate, and one below rated wind."""
    made = schedule_ranges.ScheduleRange
    ranges = [made(F("18.0297"), F("18.5276"), 0.01), made(F("9.1632"), F("9.6258"), 0.01)]
    monkeypatch.setattr(schedule_ranges, "schedule_ranges", lambda gains: ranges)
    told: list[str] = []
    document["claims"], why = schedule_claims(*parts(document), told.append)
    assert verdicts(document) == ("PROVED", "PROVED")
    assert list(why) == ["schedule-rate, 9.1632 to 9.6258 m/s at 0.01 m/s^2"]
    assert told[0] == "moving wind, range 1 of 2: attempt 1 of 10 at most"
    assert "moving wind, range 1 of 2: proof, cell 2 of 2" in told


# What is told.


def design_of(document: dict[str, Any]) -> Any:
    whole = sealed(deepcopy(document))
    return SimpleNamespace(document=whole, checked=check_document(deepcopy(whole)))


def test_summary_and_report_have_the_winds_the_rate_and_the_speed(document: dict[str, Any]) -> None:
    """The speed against numpy's inverse, and against the checker's sentence."""
    design = design_of(document)
    (found,) = claim_summary.kept_in_moving_wind(design)
    functions = document["claims"][0]["functions"]
    width = max(np.sqrt(np.linalg.inv(np.array(one["P"]))[0, 0]) for one in functions)
    fastest = max(document["gains"]["rotor_speed"])
    expected = (fastest + width) / document["model"]["rated_rotor_speed"]
    assert float(found.share) == pytest.approx(expected, rel=1e-9)
    assert (found.rate, found.schedule) == (0.03, (17.034, 18.5276))
    low, high = document["claims"][0]["winds"][0]
    name, figure, remark = report_verdict._in_moving_wind(design)[0]
    assert name == f"Wind within {low:g} to {high:g} m/s"
    assert figure == "|v'| up to 0.03 m/s²"
    share = remark.partition(" % of rated")[0].rpartition(" ")[2]
    assert f"at or below {share} % of its rated speed" in design.checked.claims[0].text
    assert "schedule wind of 17.034 to 18.5276 m/s" in remark
    told = turbine_summary._moving_wind(design)
    assert f"at most 0.03 m/s^2 within {low:g} to {high:g} m/s: {share} %" in told


def test_a_claim_that_is_not_proved_is_in_neither(document: dict[str, Any]) -> None:
    document["claims"][0]["cells"][0]["wind_rate"] *= 1.5
    design = design_of(document)
    assert report_verdict._in_moving_wind(design) == []
    assert turbine_summary._moving_wind(design) == ""


def test_a_range_without_a_claim_is_told(document: dict[str, Any]) -> None:
    words = {
        "schedule-rate, 12 to 14 m/s at 0.008 m/s^2": "not claimed: none",
        "joint analysis": "",
    }
    assert claim_summary.not_kept_above_rated({"provenance": {"solver": words}}) == (
        "moving wind above rated, 12 to 14 m/s at 0.008 m/s^2: not claimed: none",
    )
    assert claim_summary.not_kept_above_rated(document) == ()


def test_the_setting_is_recorded_only_where_it_is_asked_for() -> None:
    """A file without these claims is the same as before there was this setting."""
    name = "moving_wind_above_rated"
    assert name not in provenance.plain(DesignSettings())
    asked = provenance.plain(replace(DesignSettings(), moving_wind_above_rated=True))
    assert asked[name] is True


# The command line.


def test_the_option_belongs_to_the_effort_sharing_law(tmp_path: Path, capsys: Capture) -> None:
    for verb, out in (("design", tmp_path / "design"), ("certify", tmp_path / "certificate.json")):
        options = ["--law", "paper", "--moving-wind-above-rated", "--out", str(out)]
        assert main([verb, "nrel5mw", *options]) == 2
        words = " ".join(capsys.readouterr().err.split())
        assert "--moving-wind-above-rated belongs to the effort-sharing law" in words


def test_certify_takes_the_option_for_given_gains(
    document: dict[str, Any], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search is asked for, and a range without a claim is told, in words and in JSON."""
    asked: dict[str, Any] = {}
    del document["controller"]
    whole = sealed(document)
    key = "schedule-rate, 12.1509 to 14.0467 m/s at 0.008 m/s^2"
    whole["provenance"]["solver"] = {key: "not claimed: no quadratic function was found"}

    def certify_law(turbine: Any, law: Any, **options: Any) -> Any:
        asked.update(options)
        return whole, check_document(deepcopy(whole))

    monkeypatch.setattr(turbine_law, "certify_law", certify_law)
    gains, out = tmp_path / "gains.json", tmp_path / "certificate.json"
    gains.write_text(json.dumps({"law": document["gains"]}))
    command = ["certify", "nrel5mw", "--gains", str(gains), "--out", str(out)]
    words = key.removeprefix("schedule-rate")
    note = f"moving wind above rated{words}: not claimed: no quadratic function was found"
    assert main([*command, "--moving-wind-above-rated"]) == 0
    assert asked["moving_wind_above_rated"] is True
    assert note in capsys.readouterr().out
    assert main([*command, "--json"]) == 0
    assert asked["moving_wind_above_rated"] is False
    assert any(line.startswith(note) for line in json.loads(capsys.readouterr().out)["notes"])
