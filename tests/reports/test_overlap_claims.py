"""Pages about a published law: the claims for its overlaps, in words, pictures and tables."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from takagi.certificates import Claim, DesignSettings, TurbineDesign, Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.cli.terminal.turbine_summary import as_text
from takagi.models import nrel5mw
from takagi.reports.loops import plant_claims as overlap_module
from takagi.reports.loops.plant_claims import gap_words, overlap_claims, wind_words
from takagi.reports.sections.turbine.cells import gains_section
from takagi.reports.sections.turbine.page import claims_section, verdict_section
from tests.reports.html_page import HtmlPage, checked_as, text_of
from tests.reports.published_designs import with_published_law
from tests.undrawn import unmeasured


@pytest.fixture(autouse=True)
def _unmeasured(monkeypatch: pytest.MonkeyPatch) -> None:
    unmeasured(monkeypatch)


def with_paper_law(design: TurbineDesign) -> TurbineDesign:
    """The shared design with the published law in place of its own."""
    return with_published_law(
        design,
        settings=DesignSettings(law="paper"),
        document={
            "gains": {"name": "paper"},
            "model": {},
            "claims": [{"kind": "decay", "name": "decay"}],
            "provenance": {"sha256": {}, "versions": {}},
        },
        checked=checked_as([Claim("decay", Verdict.UNDECIDED, "from 12 m/s")]),
    )


FIGURES = {"decay": ("0.00233", "0.0997"), "speed_share": "3.53", "half_width": "0.015"}
NONE = {"proved": (), "unproved": ((3.0, 25.0),), "decay": (), "speed_share": "", "half_width": ""}
CELLS = {"proved": ((3.0, 10.084124), (10.413799, 25.0)), "unproved": ((10.084124, 10.413799),)}


@pytest.fixture(autouse=True)
def _replayed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cells of a stub are those of its claims: none is replayed."""
    monkeypatch.setattr(overlap_module, "proved_cells", lambda *_: FIGURES | CELLS)


def overlap_design(
    text: str = "proved for", verdict: Verdict = Verdict.UNDECIDED, name: str = "paper"
) -> TurbineDesign:
    """A stub of a design with the claim about its law, with a gap."""
    own: dict[str, Any] = {"speed_overlap": 0.1, "torque_overlap": 2000.0, "winds": [[3.0, 25.0]]}
    gap = {"kind": "paper-loop", "unproved": [{"wind": [10.084124595, 10.413798828]}]}
    checked = [Claim("own <overlaps>", verdict, text)]
    stub = SimpleNamespace(
        turbine=nrel5mw(),
        settings=DesignSettings(law=name),
        law=SimpleNamespace(name=name),
        effort_sharing_law=None,
        notes=(),
        synthesis=None,
        measured=None,
        document={"claims": [own | gap], "gains": {"coupling": own}},
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


def test_only_winds_of_cells_that_hold_are_proved() -> None:
    """Those of the cells that hold, with their bounds."""
    (own,) = overlap_claims(overlap_design())

    assert own.proved == ((3.0, 10.084124), (10.413799, 25.0))
    assert own.unproved == ((10.084124, 10.413799),)
    assert wind_words(own) == "3 to 10.084, 10.414 to 25 m/s"
    assert gap_words(own) == "10.084 to 10.414 m/s"
    assert (own.decay, own.speed_share, own.half_width) == (("0.00233", "0.0997"), "3.53", "0.015")


def test_a_claim_without_cells_that_hold_proves_no_wind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every wind is left, without bounds, and the terminal quotes the checker."""
    monkeypatch.setattr(overlap_module, "proved_cells", lambda *_: NONE)
    design = overlap_design("proved at no wind for speed overlap 0.1 rad/s")

    assert wind_words(overlap_claims(design)[0]) == "none"
    assert "proved at no wind for speed" in " ".join(as_text(design).split())


def test_overlaps_are_a_picture_a_table_and_folded_words() -> None:
    """Of Schulte's law: one figure with the gap, then a row per claim."""
    section = verdict_section(overlap_design())
    screen, claims = (
        text_of(each).replace("\N{NO-BREAK SPACE}", " ")
        for each in (section, claims_section(overlap_design()))
    )
    page = HtmlPage(screen + claims)

    assert [captioned.name for captioned in section.captioned_figures] == ["overlaps"]
    assert sum(1 for a in page.all("th") if a.get("scope") == "row") == 1
    assert "0.015 rad/s" in claims
    assert page.wrong == [] and page.open == []
    assert "not 10.084 to 10.414 m/s" in screen and "0.00233 to 0.0997" in screen
    assert "own &lt;overlaps&gt;" in claims


def test_terminal_tells_the_overlaps() -> None:
    """The law's overlaps, with the gap."""
    lines = as_text(overlap_design()).splitlines()

    assert lines[0].startswith("UNDECIDED  NREL 5-MW, Schulte's law")
    assert " ".join(" ".join(lines[1:3]).split()) == (
        "proved winds 3 to 10.084, 10.414 to 25 m/s, overlaps of 0.1 rad/s, 2000 N m "
        "<- not 10.084 to 10.414 m/s"
    )
    assert max(map(len, lines)) <= 100 and len(lines) <= 20
