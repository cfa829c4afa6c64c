"""The HTML report: well-formed, self-contained, whole, and honest about what is not proved."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from takagi.certificates import Claim, DesignSettings, TurbineDesign, Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.certificates.document.certificate_file import dumps
from takagi.cli.terminal.turbine_summary import as_text
from takagi.models import nrel5mw
from takagi.models.errors import ModelError
from takagi.models.loading import read_model
from takagi.reports.design_folder import design_files, read_design, report_files
from takagi.reports.loops import plant_claims as overlap_module
from takagi.reports.loops.plant_claims import gap_words, overlap_claims, wind_words
from takagi.reports.margins import running_over_wind
from takagi.reports.output import write_folder
from takagi.reports.page.text import at_most
from takagi.reports.sections.turbine.model import gains_section
from takagi.reports.sections.turbine.page import claims_section, verdict_section
from takagi.reports.sections.turbine.summary import summary_rows
from takagi.reports.simulation import measured_loop as measuring
from takagi.reports.simulation.measured_loop import measured_loop
from tests.reports.html_page import HtmlPage, checked_as, self_contained, text_of, unsettled
from tests.reports.published_designs import with_published_law
from tests.undrawn import unmeasured

FIGURES = {
    "gust", "power-coefficient", "trim", "gains", "effort-ramp", "cells",
    "bode-torque", "bode-pitch", "running-margins", "response-step-up", "response-step-down",
    "response-gust", "response-ramp",
}  # fmt: skip
SECTIONS = (
    "verdict", "law", "model", "claims", "certificate", "running", "responses",
    "observer", "check", "provenance",
)  # fmt: skip


@pytest.fixture(scope="module")
def files(turbine_design: TurbineDesign) -> dict[str, bytes | str]:
    """The whole folder of the shared design: short responses, and margins at four winds."""
    with unsettled() as patch:
        patch.setattr(running_over_wind, "FINE", 11.0)
        patch.setattr(measuring, "DURATION", 60.0)
        patch.setattr(measuring, "GUSTS", (8.5,))
        patch.setattr(measuring, "TURBULENT", (11.0,))
        patch.setattr(measuring, "TURBULENT_DURATION", 30.0)
        return design_files(turbine_design)


@pytest.fixture(scope="module")
def html(files: dict[str, bytes | str]) -> str:
    text = files["report.html"]
    assert isinstance(text, str)
    return text


@pytest.fixture(scope="module")
def page(html: str) -> HtmlPage:
    return HtmlPage(html)


def undecided(design: TurbineDesign) -> TurbineDesign:
    """The shared design, with a checker that refused its third wind cell."""
    low, high = design.document["claims"][0]["cells"][2]["wind"]
    text = f"not proved, of 70 wind cells: wind {low:g} to {high:g} m/s: <limit>"
    claim = Claim("effort-sharing loop", Verdict.UNDECIDED, text)
    resting = [
        replace(other, verdict=Verdict.UNDECIDED, text="what it rests on is not proved")
        for other in design.checked.claims[1:]
    ]
    return replace(design, checked=checked_as([claim, *resting]))


def test_page_is_well_formed_and_self_contained(html: str) -> None:
    """And it weighs less than 1.5 MB."""
    self_contained(html)

    assert len(html.encode()) < 1_500_000


def test_sections_in_order_with_headings(page: HtmlPage) -> None:
    sections = [attributes["id"] for attributes in page.all("section")]
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]

    assert sections == list(SECTIONS)
    assert levels.count(1) == 1
    assert all(b - a <= 1 for a, b in zip(levels, levels[1:], strict=False))


def test_figures_in_page_and_folder(page: HtmlPage, files: dict[str, bytes | str]) -> None:
    in_page = {str(a["id"]).removeprefix("figure-") for a in page.all("figure")}
    in_folder = {name for name in files if name.startswith("figures/")}

    assert in_page == FIGURES
    assert in_folder == {f"figures/{name}.svg" for name in FIGURES}
    assert all(len(str(a.get("aria-label", ""))) > 20 for a in page.all("svg"))


def test_page_can_be_read_on_a_phone_and_aloud(page: HtmlPage) -> None:
    tables = [a for a in page.all("table") if a.get("role") != "presentation"]

    assert any(a.get("name") == "viewport" for a in page.all("meta"))
    assert sum(1 for _ in page.all("caption")) == len(tables)
    assert sum(1 for a in page.all("th") if a.get("scope") == "row") > 100


def test_folder_holds_the_certificate_as_it_is(
    turbine_design: TurbineDesign, files: dict[str, bytes | str]
) -> None:
    assert files["certificate.json"] == dumps(turbine_design.document)
    assert str(files["gains.json"]).startswith('{\n"format": "takagi-gains"')


def test_the_terminal_has_the_least_margin_of_the_loop_that_runs(
    files: dict[str, bytes | str], turbine_design: TurbineDesign
) -> None:
    """Of all plants, winds and loops of the report, in 20 lines of at most 100 characters."""
    rows = measured_loop(turbine_design).margins.rows
    phases = [np.degrees(each.phase) for row in rows for _, each in row.loops]
    lines = as_text(turbine_design).splitlines()
    (number,) = re.findall(r"phase ([\d.]+) deg", " ".join(" ".join(lines).split()))

    assert len(files) > 3 and len(lines) <= 20 and max(map(len, lines)) <= 100
    assert float(number) == pytest.approx(min(phases), rel=0.01)


def test_first_screen_has_the_weak_numbers_beside_the_proved_ones(
    files: dict[str, bytes | str], turbine_design: TurbineDesign
) -> None:
    claim = turbine_design.document["claims"][0]
    speed = max(turbine_design.document["gains"]["rotor_speed"]) + claim["peaks"]["speed_error"]
    over = 100 * (speed / turbine_design.turbine.rated_rotor_speed - 1)
    rows = {row.name: row for row in summary_rows(turbine_design)}
    screen = text_of(verdict_section(turbine_design)).replace("\N{NO-BREAK SPACE}", " ")
    runs = measured_loop(turbine_design).runs
    largest = max(run.law.metrics.overspeed for run in runs)

    assert files and rows["rotor speed"].numbers[0].value == pytest.approx(over, rel=1e-9)
    assert f"{at_most(over)} %" in screen
    assert f"{largest:.1f} %" in screen and rows["overspeed"].partial
    assert rows["overspeed"].claim == "" and rows["rotor speed"].claim
    assert rows["margins"].parts[0] in screen and "regions" not in screen
    assert screen.count('class="figure"') == 6


def test_runs_say_when_they_are_inside_the_proved_wind_class(
    files: dict[str, bytes | str], turbine_design: TurbineDesign
) -> None:
    run = measured_loop(turbine_design).drawn["gust"]
    assert files and run.law.line is not None
    wind = run.law.line.wind
    inside = measuring.in_wind_class(turbine_design, run.time, wind, run.schedule)
    assert inside is not None
    assert inside[run.time < 10].all() and not inside[int(np.argmax(wind))]
    assert 0 < run.share_inside < 1


@pytest.mark.slow
def test_a_folder_keeps_margins_and_runs_as_data(
    files: dict[str, bytes | str],
    turbine_design: TurbineDesign,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with unsettled():
        given = design_files(turbine_design, source=read_model("nrel5mw"))
        folder = write_folder(tmp_path / "out", given)
        monkeypatch.setattr("takagi.reports.simulation.measured_loop._measured_now", None)

        assert report_files(read_design(folder))["report.html"] == given["report.html"]

    record = json.loads(str(given["design.json"]))
    members = record["design"]["members"]
    kept = members.pop("measured")
    (folder / "design.json").write_text(json.dumps(record))
    design = read_design(folder)
    assert isinstance(design, TurbineDesign) and design.measured is None
    for forged in ({**kept, "class": "takagi.models.simulation.scenario:Metrics"}, 3, [kept]):
        members["measured"] = forged
        (folder / "design.json").write_text(json.dumps(record))
        with pytest.raises(ModelError, match="design again"):
            read_design(folder)


def test_each_claim_has_its_own_assumptions(
    files: dict[str, bytes | str], turbine_design: TurbineDesign
) -> None:
    """What only the loop with the observer assumes stands in its row alone."""
    first, *_, last = claims_section(turbine_design).content["rows"]
    own = set(turbine_design.checked.claims[-1].assumes) - set(
        turbine_design.checked.claims[0].assumes
    )

    assert files and own
    assert all(phrase in last["assumes"] and phrase not in first["assumes"] for phrase in own)


def test_a_cell_that_is_not_proved_is_named(
    turbine_design: TurbineDesign, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = undecided(turbine_design)
    unmeasured(monkeypatch)
    low, high = design.document["claims"][0]["cells"][2]["wind"]
    found = claim_summary(design)
    assert found is not None

    screen, claims = text_of(verdict_section(design)), text_of(claims_section(design))

    assert found.proved.count(False) == 1 and not found.proved[2]
    assert "UNDECIDED" in screen and "PROVED</span>" not in screen + claims
    assert f"{low:g} to {high:g} m/s" in claims and "&lt;limit&gt;" in claims
    assert all(not row.claim for row in summary_rows(design))


def test_a_list_cut_short_leaves_nothing_proved(turbine_design: TurbineDesign) -> None:
    design = undecided(turbine_design)
    claim = replace(design.checked.claims[0], text="wind 3 to 4 m/s: x (+58 more)")
    found = claim_summary(replace(design, checked=checked_as([claim])))

    assert found is not None
    assert not any(found.proved)


def with_paper_law(design: TurbineDesign) -> TurbineDesign:
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


OVERLAP_FIGURES = {"decay": ("0.00233", "0.0997"), "speed_share": "3.53", "half_width": "0.015"}
NONE = {"proved": (), "unproved": ((3.0, 25.0),), "decay": (), "speed_share": "", "half_width": ""}
CELLS = {"proved": ((3.0, 10.084124), (10.413799, 25.0)), "unproved": ((10.084124, 10.413799),)}


@pytest.fixture
def replayed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cells of a stub are those of its claims: none is replayed, and no loop is measured."""
    unmeasured(monkeypatch)
    monkeypatch.setattr(overlap_module, "proved_cells", lambda *_: OVERLAP_FIGURES | CELLS)


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


@pytest.mark.usefixtures("replayed")
def test_a_paper_law_has_its_own_words(turbine_design: TurbineDesign) -> None:
    design = with_paper_law(turbine_design)

    box, law = text_of(claims_section(design)), text_of(gains_section(design))

    assert claim_summary(design) is None
    assert "from 12 m/s" in box and "UNDECIDED" in box
    assert "4 × 4 × 8 = 128 rules" in law


@pytest.mark.usefixtures("replayed")
def test_only_winds_of_cells_that_hold_are_proved() -> None:
    (own,) = overlap_claims(overlap_design())

    assert own.proved == ((3.0, 10.084124), (10.413799, 25.0))
    assert own.unproved == ((10.084124, 10.413799),)
    assert wind_words(own) == "3 to 10.084, 10.414 to 25 m/s"
    assert gap_words(own) == "10.084 to 10.414 m/s"
    assert (own.decay, own.speed_share, own.half_width) == (("0.00233", "0.0997"), "3.53", "0.015")


@pytest.mark.usefixtures("replayed")
def test_a_claim_without_cells_that_hold_proves_no_wind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overlap_module, "proved_cells", lambda *_: NONE)
    design = overlap_design("proved at no wind for speed overlap 0.1 rad/s")

    assert wind_words(overlap_claims(design)[0]) == "none"
    assert "proved at no wind for speed" in " ".join(as_text(design).split())


@pytest.mark.usefixtures("replayed")
def test_overlaps_are_a_picture_a_table_and_folded_words() -> None:
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


@pytest.mark.usefixtures("replayed")
def test_terminal_tells_the_overlaps() -> None:
    lines = as_text(overlap_design()).splitlines()

    assert lines[0].startswith("UNDECIDED  NREL 5-MW, Schulte's law")
    assert " ".join(" ".join(lines[1:3]).split()) == (
        "proved winds 3 to 10.084, 10.414 to 25 m/s, overlaps of 0.1 rad/s, 2000 N m "
        "<- not 10.084 to 10.414 m/s"
    )
    assert max(map(len, lines)) <= 100 and len(lines) <= 20
