"""``turbine-crossing``: the search, and the option of the command line."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest

from takagi.certificates import DesignSettings
from takagi.certificates.claims.turbine import (
    MEAN_WINDS,
    CrossingAsked,
    crossing_claim,
    crossing_claims,
)
from takagi.certificates.claims.turbine.linear_loop import turbine_crossing_claim
from takagi.cli.main import main
from takagi.models import ModelError
from takagi.models.turbine import RotorWind
from tests.certificates.turbine.crossing_documents import (
    BOTH,
    Data,
    stored_documents,
)
from tests.certificates.turbine.running_documents import verdicts

KIND = "turbine-crossing"


@pytest.fixture(scope="module")
def stored() -> list[Data]:
    return stored_documents()


@pytest.fixture
def document(stored: list[Data]) -> Data:
    return deepcopy(stored[0])


# Candidates.


def _given(document: Data) -> tuple[Data, Data, Data, list[float]]:
    return document["model"], document["gains"], document["controller"], [0.9, 1.1]


def test_a_candidate_is_proved_with_the_least_overspeed(document: Data) -> None:
    """At 9 m/s 20 % has 0.00106, and 25 % 3e-6: the probability asked for is 10^-3."""
    asked = CrossingAsked(9.0, RotorWind.of_class("B", 9.0))
    (claim,), why = crossing_claim(*_given(document), asked)
    assert why == {}
    assert claim["overspeed"] == 0.25
    assert 1e-6 < claim["probability"] < 1e-5
    document["claims"] = [claim]
    assert verdicts(document) == BOTH


@pytest.mark.slow
def test_pieces_are_cut_until_the_probability_is_shown(document: Data) -> None:
    """At 9 m/s and 20 % one covariance shows 0.00106; a few pieces show 0.00095."""
    one = CrossingAsked(9.0, RotorWind.of_class("B", 9.0), 9.5e-4, 0.2)
    claims, why = crossing_claim(*_given(document), one)
    assert claims == []
    assert "no covariance shows 0.00095 for an overspeed of 20 % at 9 m/s" in why[KIND]
    (claim,), _ = crossing_claim(*_given(document), replace(one, pieces=8, least=False))
    assert 1 < len(claim["C"]) <= 8
    assert claim["probability"] == 9.5e-4
    document["claims"] = [claim]
    assert verdicts(document) == BOTH


def test_no_more_pieces_are_sought_than_the_checker_takes(
    document: Data, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A certificate with more would be refused: the corners of two pieces are the most here."""
    monkeypatch.setattr(turbine_crossing_claim, "MOST_WORK", 2 * 32 * 13**4)
    asked = CrossingAsked(9.0, RotorWind.of_class("B", 9.0), 5e-4, 0.2, pieces=8, depth=3)
    claims, why = crossing_claim(*_given(document), asked)
    assert claims == []
    assert " found on 2 pieces is " in why[KIND]
    assert why[KIND].endswith("; the checker takes no more")


def test_what_has_no_linear_loop_has_no_claim(document: Data) -> None:
    wind = RotorWind.of_class("B", 5.0)
    claims, why = crossing_claim(*_given(document), CrossingAsked(5.0, wind))
    assert claims == []
    assert why == {KIND: "not claimed: the wind is not between two nodes of the law's tables"}
    document["controller"].pop("measurement")
    _, why = crossing_claim(*_given(document), CrossingAsked(8.0, wind))
    assert "no low-pass on the measured speed" in why[KIND]


@pytest.mark.parametrize(("part", "value"), [("measurement", None), ("observer", [1.0, 2.0])])
def test_a_part_that_is_no_object_is_misuse(document: Data, part: str, value: object) -> None:
    """A law without it leaves the member out; that is answered, and this is not."""
    document["controller"][part] = value
    asked = CrossingAsked(8.0, RotorWind.of_class("B", 8.0))
    with pytest.raises(ModelError, match=rf"controller\['{part}'\] is .*leave the member out"):
        crossing_claim(*_given(document), asked)


def test_the_classes_of_turbulence() -> None:
    """Class B as measured, A and C by the reference intensities 0.16, 0.14 and 0.12 of IEC."""
    assert RotorWind.of_class("B", 8.0) == RotorWind(1.09, 0.09)
    for letter, share in (("A", 0.16 / 0.14), ("C", 0.12 / 0.14)):
        found = RotorWind.of_class(letter, 15.0)
        assert found.deviation == pytest.approx(1.64 * share, rel=1e-3)
        assert found.rate == pytest.approx(0.2 * share, rel=1e-3)
    with pytest.raises(ModelError, match="turbulence class 'D'"):
        RotorWind.of_class("D", 8.0)
    with pytest.raises(ModelError, match="positive numbers"):
        RotorWind(0.0, 0.1)


# The command line.


def test_the_option_belongs_to_the_effort_sharing_law_and_has_three_values(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for options, words in (
        (["--law", "paper", "--turbulence", "B"], "--turbulence belongs to the effort-sharing law"),
        (["--turbulence", "D"], "option --turbulence: 'D' was given; a class of turbulence"),
    ):
        assert main(["design", "nrel5mw", *options, "--out", str(tmp_path)]) == 2
        assert words in " ".join(capsys.readouterr().err.split())
    with pytest.raises(ModelError, match="turbulence class 'D' was given"):
        DesignSettings(turbulence="D")


@pytest.mark.slow
def test_a_law_gets_the_claims_on_request(document: Data) -> None:
    """Ten mean winds, all proved; the words before each wind are told."""
    told: list[str] = []
    claims, why = crossing_claims(*_given(document), "B", told.append)
    assert [claim["wind"] for claim in claims] == list(MEAN_WINDS)
    assert why == {}
    assert told[0] == "linear loop in turbulence, at 5.2 m/s"
    assert len(told) == len(MEAN_WINDS)
    assert max(claim["probability"] for claim in claims) <= 1e-3
    document["claims"] = claims
    assert len(json.dumps(claims)) < 40_000
    assert verdicts(document) == BOTH
