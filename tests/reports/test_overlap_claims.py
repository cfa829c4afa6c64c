"""Pages about a published law: the claims for its overlaps, in words, pictures and tables."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from takagi.certificates import Claim, DesignSettings, TurbineDesign, Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.cli.terminal.turbine_summary import as_text
from takagi.models import nrel5mw
from takagi.models.laws.published.law import PublishedLawName
from takagi.reports.loops.overlap_claims import gap_words, overlap_claims, wind_words
from takagi.reports.sections.turbine.gains import gains_section
from takagi.reports.sections.turbine.verdict import claims_section, verdict_section
from tests.reports.html_page import HtmlPage, checked_as, text_of
from tests.reports.published_designs import with_published_law
from tests.undrawn import unmeasured


@pytest.fixture(autouse=True)
def _unmeasured(monkeypatch: pytest.MonkeyPatch) -> None:
    unmeasured(monkeypatch)


def with_paper_law(design: TurbineDesign) -> TurbineDesign:
    """The shared design with the published law of two integrators in place of its own."""
    name: PublishedLawName = "paper-two-integrators"
    return with_published_law(
        design,
        name,
        settings=DesignSettings(law=name),
        document={
            "gains": {"name": name},
            "model": {},
            "claims": [{"kind": "decay", "name": "decay"}],
            "provenance": {"sha256": {}, "versions": {}},
        },
        checked=checked_as([Claim("decay", Verdict.UNDECIDED, "from 12 m/s")]),
    )


WINDOWS = [[v + 0.5, v + 0.53] for v in range(3, 25)]
BOUNDS = (
    "at each constant wind, v_hat = v, one equilibrium in a stated set (speed within 0.0005 to "
    "0.015 rad/s), reached from all of it at no less than 0.00233 to 0.0997 1/s (by wind, 551 "
    "cells); there the speed is within 3.53 % of rated of its reference, pitch within 2 deg of "
    "the trim tables'"
)
GAP = f"proved for winds 3 to 10.084124, 10.413799 to 25 m/s with speed overlap 0.1: {BOUNDS}"


def overlap_design(
    text: str = GAP, verdict: Verdict = Verdict.UNDECIDED, name: str = "paper"
) -> TurbineDesign:
    """A stub of a design with two claims: the law's own overlaps, and 20 of 22 windows of others.

    The words are those that the checker prints.
    """
    own = {"speed_overlap": 0.1, "torque_overlap": 2000.0, "winds": [[3.0, 25.0]]}
    other = {"speed_overlap": 0.05, "torque_overlap": 1000.0, "winds": WINDOWS[:20]}
    gaps = [[10.084124595, 10.413798828]], WINDOWS[20:]
    claims: list[dict[str, Any]] = [
        {**claim, "kind": "paper-loop", "unproved": [{"wind": gap} for gap in left]}
        for claim, left in zip((own, other), gaps, strict=True)
    ]
    checked = [
        Claim("own <overlaps>", verdict, text),
        Claim("other overlaps", Verdict.PROVED, f"proved for winds in windows: {BOUNDS}"),
    ]
    stub = SimpleNamespace(
        turbine=nrel5mw(),
        settings=DesignSettings(law=name),
        law=SimpleNamespace(name=name),
        effort_sharing_law=None,
        notes=(),
        synthesis=None,
        document={"claims": claims, "gains": {"coupling": own}},
        checked=checked_as(checked),
        verdict_words=checked_as(checked).verdict.name,
        proved=checked_as(checked).verdict is Verdict.PROVED,
    )
    return cast(TurbineDesign, stub)


def test_a_paper_law_has_its_own_words(turbine_design: TurbineDesign) -> None:
    """With a published law the page shows its equation and claims, not those of the other law."""
    design = with_paper_law(turbine_design)

    box, law = text_of(claims_section(design)), text_of(gains_section(design))

    assert claim_summary(design) is None
    assert "from 12 m/s" in box and "UNDECIDED" in box
    assert "4 × 4 × 8 = 128 rules" in law


def test_only_winds_that_the_checker_names_are_proved() -> None:
    """All winds of a PROVED claim; of an UNDECIDED one the ranges named, the rest is left."""
    own, other = overlap_claims(overlap_design())

    assert own.chosen and not other.chosen
    assert own.proved == ((3.0, 10.084124), (10.413799, 25.0))
    assert own.left == ((10.084124, 10.413799),)
    assert wind_words(own) == "3 to 10.084, 10.414 to 25 m/s"
    assert gap_words(own) == "10.084 to 10.414 m/s"
    assert (own.decay, own.speed_share, own.half_width) == (("0.00233", "0.0997"), "3.53", "0.015")
    assert len(other.proved) == 20 and len(other.left) == 2
    assert wind_words(other) == "20 of 22 windows, from 3.5 to 22.5 m/s"
    whole = overlap_claims(overlap_design(verdict=Verdict.PROVED))[0]
    assert whole.proved == ((3.0, 25.0),) and whole.left == ()


@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        ("proved at no wind for speed overlap 0.1 rad/s", Verdict.UNDECIDED),
        (f"proved for winds in windows 0.03 m/s wide from 3.5 m/s with x: {BOUNDS}",
         Verdict.UNDECIDED),
        (f"proved for winds 3 to 4, about 5 to 6 m/s with x: {BOUNDS}", Verdict.UNDECIDED),
        (f"not {GAP}", Verdict.UNDECIDED),
        (GAP, Verdict.DISPROVED),
    ],
)  # fmt: skip
def test_words_not_understood_prove_no_wind(text: str, verdict: Verdict) -> None:
    """In doubt every wind is left, without bounds, and the terminal quotes the checker."""
    design = overlap_design(text, verdict)
    own = overlap_claims(design)[0]

    assert (own.proved, own.left, own.decay) == ((), ((3.0, 25.0),), ())
    assert wind_words(own) == "none"
    assert text in " ".join(as_text(design).split())


def test_winds_beyond_the_claim_are_not_taken_as_proved() -> None:
    """Ranges that a text names are cut to the winds of the claim."""
    own = overlap_claims(overlap_design(GAP.replace("3 to 10.084124", "1 to 10.084124")))[0]

    assert own.proved[0] == (3.0, 10.084124)


def test_overlaps_are_a_picture_a_table_and_folded_words() -> None:
    """Of Schulte's law: one figure with the gap, then a row per claim and per pair of overlaps."""
    section = verdict_section(overlap_design())
    screen, claims = (
        text_of(each).replace("\N{NO-BREAK SPACE}", " ")
        for each in (section, claims_section(overlap_design()))
    )
    page = HtmlPage(screen + claims)

    assert [captioned.name for captioned in section.captioned_figures] == ["overlaps"]
    assert sum(1 for a in page.all("th") if a.get("scope") == "row") == 4
    assert page.wrong == [] and page.open == []
    assert "not 10.084 to 10.414 m/s" in screen and "0.00233 to 0.0997" in screen
    assert "551" not in screen and "own &lt;overlaps&gt;" in claims


def test_terminal_tells_the_chosen_overlaps_and_lists_the_others() -> None:
    """The law's own overlaps with the gap; the others with --all."""
    lines = as_text(overlap_design()).splitlines()
    others = "0.05 rad/s, 1000 N m: 20 of 22 windows, from 3.5 to 22.5 m/s"

    assert lines[0].startswith("UNDECIDED  NREL 5-MW, Schulte's law")
    assert " ".join(" ".join(lines[1:3]).split()) == (
        "proved winds 3 to 10.084, 10.414 to 25 m/s, overlaps of 0.1 rad/s, 2000 N m "
        "<- not 10.084 to 10.414 m/s"
    )
    assert others not in " ".join(lines)
    assert others in " ".join(as_text(overlap_design(), every_claim=True).split())
    assert max(map(len, lines)) <= 100 and len(lines) <= 20
