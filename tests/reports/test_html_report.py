"""The HTML report: well-formed, self-contained, whole, and honest about what is not proved."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from takagi.certificates import Claim, DesignSettings, TurbineDesign, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.claim_summary import claim_summary
from takagi.certificates.document import dumps
from takagi.cli.terminal.turbine_summary import as_text
from takagi.models import nrel5mw
from takagi.models.laws import Measurement, published_law
from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.regional_schedule import regional_schedule
from takagi.reports.design_folder import design_files
from takagi.reports.loops.overlap_claims import gap_words, overlap_claims, wind_words
from takagi.reports.loops.turbine_local import loop_points
from takagi.reports.margins import LocalGains, closed_loop_poles
from takagi.reports.page import Section, at_least, render, significant, with_decimals
from takagi.reports.page.text import at_most, powers
from takagi.reports.sections.turbine import gains_section
from takagi.reports.sections.turbine.cells import cells_section
from takagi.reports.sections.turbine.loops import poles_section
from takagi.reports.sections.turbine.verdict import verdict_section

VOID = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}
FIGURES = {
    "wind-class", "power-coefficient", "trim", "gains-partial-load", "gains-full-load", "gains",
    "effort-ramp", "memberships", "cells", "poles", "bode-torque", "bode-pitch",
    "bode-pitch-frozen", "running-margins", "response-step-up", "response-step-down",
    "response-gust", "response-ramp",
}  # fmt: skip
SECTIONS = (
    "verdict", "model", "regions", "law", "blending", "certificate", "poles", "loops",
    "running", "responses", "observer", "check", "provenance",
)  # fmt: skip


class _Page(HTMLParser):
    """Notes what a page contains, and every tag that is closed out of turn."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def all(self, tag: str) -> Iterator[dict[str, str | None]]:
        return (attributes for name, attributes in self.tags if name == tag)

    @property
    def ids(self) -> list[str]:
        return [str(a["id"]) for _, a in self.tags if a.get("id")]


@pytest.fixture(scope="module")
def files(turbine_design: TurbineDesign) -> dict[str, bytes | str]:
    """The whole folder of the shared design."""
    return design_files(turbine_design)


@pytest.fixture(scope="module")
def html(files: dict[str, bytes | str]) -> str:
    """The page's text."""
    text = files["report.html"]
    assert isinstance(text, str)
    return text


@pytest.fixture(scope="module")
def page(html: str) -> _Page:
    """The page, parsed."""
    return _Page(html)


def undecided(design: TurbineDesign) -> TurbineDesign:
    """The shared design, with a checker that refused its third wind cell."""
    low, high = design.document["claims"][0]["cells"][2]["wind"]
    text = f"not proved, of 70 wind cells: wind {low:g} to {high:g} m/s: <limit>"
    claim = Claim("coherent loop", Verdict.UNDECIDED, text)
    resting = [
        replace(other, verdict=Verdict.UNDECIDED, text="what it rests on is not proved")
        for other in design.checked.claims[1:]
    ]
    return replace(design, checked=concluded([claim, *resting], []))


def with_paper_law(design: TurbineDesign) -> TurbineDesign:
    """The shared design with the published law of two integrators in the coherent law's place."""
    regional = design.regional
    schedules = [
        regional_schedule(design.turbine, part.model, k_x=k_x, k_I=k_I)
        for part in (regional.partial, regional.full)
        for k_x, k_I in [part.require()]
    ]
    law = published_law(
        design.turbine,
        partial=schedules[0],
        full=schedules[1],
        coupling=coupling_filter(design.turbine),
        name="paper-two-integrators",
    )
    return replace(
        design,
        settings=DesignSettings(law="paper-two-integrators"),
        law=law,
        effort=None,
        candidate=None,
        document={
            "gains": {"name": law.name},
            "model": {},
            "claims": [{"kind": "quadratic-decay", "name": "decay"}],
            "provenance": {"sha256": {}, "versions": {}},
        },
        checked=concluded([Claim("decay", Verdict.UNDECIDED, "from 12 m/s")], []),
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
        candidate=None,
        document={"claims": claims, "gains": {"coupling": own}},
        checked=concluded(checked, []),
    )
    return cast(TurbineDesign, stub)


def text_of(section: Section) -> str:
    """The section as it stands in the page."""
    return render(section, "turbine")


def test_page_is_well_formed(page: _Page) -> None:
    """Every element is closed, in turn, and no id stands twice."""
    assert page.wrong == []
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))


def test_page_loads_nothing(page: _Page, html: str) -> None:
    """No script, style sheet, image, font or frame is fetched from anywhere."""
    assert not {"script", "link", "img", "iframe", "object"} & {tag for tag, _ in page.tags}
    assert "@import" not in html
    for reference in re.findall(r'(?:src|href)="([^"]*)"', html):
        assert reference.startswith("#"), reference
    assert not re.search(r"url\((?!#)", html)


def test_every_link_has_its_target(page: _Page) -> None:
    """Each link of the page, and each reference inside a figure, leads to an id that exists."""
    ids = set(page.ids)
    for tag in ("a", "use"):
        for attributes in page.all(tag):
            target = attributes.get("href") or attributes.get("xlink:href") or ""
            assert target.removeprefix("#") in ids, target


def test_sections_in_order_with_headings(page: _Page) -> None:
    """All sections stand in their order, the verdict first; one h1, and no level is skipped."""
    sections = [attributes["id"] for attributes in page.all("section")]
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]

    assert sections == list(SECTIONS)
    assert levels.count(1) == 1
    assert all(b - a <= 1 for a, b in zip(levels, levels[1:], strict=False))


def test_figures_in_page_and_folder(page: _Page, files: dict[str, bytes | str]) -> None:
    """Every figure is in the page, with a text in its place, and in a file of its own."""
    in_page = {str(a["id"]).removeprefix("figure-") for a in page.all("figure")}
    in_folder = {name for name in files if name.startswith("figures/")}

    assert in_page == FIGURES
    assert in_folder == {f"figures/{name}.svg" for name in FIGURES}
    assert all(len(str(a.get("aria-label", ""))) > 20 for a in page.all("svg"))


def test_tables_have_captions_and_headings(page: _Page) -> None:
    """Each table but the typeset matrices has a caption."""
    captions = sum(1 for _ in page.all("caption"))
    tables = [a for a in page.all("table") if a.get("role") != "presentation"]

    assert captions == len(tables)
    assert sum(1 for a in page.all("th") if a.get("scope") == "row") > 100


def test_page_fits_a_phone_and_the_limit(page: _Page, html: str) -> None:
    """The page names its width for phones and weighs less than 3 MB."""
    assert any(a.get("name") == "viewport" for a in page.all("meta"))
    assert len(html.encode()) < 3_000_000


def test_folder_holds_the_certificate_as_it_is(
    turbine_design: TurbineDesign, files: dict[str, bytes | str]
) -> None:
    """The folder's certificate is the design's document."""
    assert files["certificate.json"] == dumps(turbine_design.document)
    assert str(files["gains.json"]).startswith('{\n"format": "takagi-gains"')


def test_verdict_states_the_certificates_numbers(turbine_design: TurbineDesign, html: str) -> None:
    """Decay, overspeed and winds of the verdict are the certificate's, rounded to the safe side."""
    summary = claim_summary(turbine_design)
    assert summary is not None
    claim = turbine_design.document["claims"][0]
    decay = min(cell["decay_rate"] for cell in claim["cells"])
    speed = max(turbine_design.document["gains"]["rotor_speed"]) + claim["peaks"]["speed_error"]
    common = claim["settling"]["decay_rate"]

    assert summary.decay_rate == decay
    assert summary.common_rate == common
    assert summary.overspeed == pytest.approx(
        speed / turbine_design.turbine.rated_rotor_speed - 1, rel=1e-12
    )
    assert f"≥ {at_least(common)} 1/s" in html
    assert f"{at_least(decay)} 1/s" in html
    assert f"≤ {at_most(100 * summary.overspeed, 2)} % above rated" in html


def test_the_page_names_what_the_verdict_assumes(turbine_design: TurbineDesign, html: str) -> None:
    """The checker's own line, once, above what is left out."""
    line = escape("; ".join(turbine_design.checked.assumes))

    assert "torque at once and without rate limit" in line
    assert html.count(f"<b>Assumes:</b> {line}.") == 1
    assert html.index(line) < html.index('id="left-out"')


@pytest.mark.slow
def test_same_design_same_section(turbine_design: TurbineDesign) -> None:
    """Sections of one design are the same text every time, figures included."""
    for make in (verdict_section, cells_section):
        assert text_of(make(turbine_design)) == text_of(make(turbine_design))


def test_a_cell_that_is_not_proved_is_named(turbine_design: TurbineDesign) -> None:
    """UNDECIDED is printed as such, with the wind of the cell; nothing is called proved."""
    design = undecided(turbine_design)
    low, high = design.document["claims"][0]["cells"][2]["wind"]
    summary = claim_summary(design)
    assert summary is not None

    box = text_of(verdict_section(design))

    assert summary.proved.count(False) == 1 and not summary.proved[2]
    assert "UNDECIDED" in box and "PROVED</span>" not in box
    assert f"{low:g} to {high:g} m/s" in box
    assert "&lt;limit&gt;" in text_of(cells_section(design))


def test_a_list_cut_short_leaves_nothing_proved(turbine_design: TurbineDesign) -> None:
    """Where the checker's list of failures is cut, no cell is taken as proved."""
    design = undecided(turbine_design)
    claim = replace(design.checked.claims[0], text="wind 3 to 4 m/s: x (+58 more)")
    summary = claim_summary(replace(design, checked=concluded([claim], [])))

    assert summary is not None
    assert not any(summary.proved)


@pytest.mark.parametrize("wind", [8.0, 11.45, 18.0])
def test_local_gains_are_the_laws_derivatives(turbine_design: TurbineDesign, wind: float) -> None:
    """The formulas for the local gains agree with central differences of the law itself."""
    law = turbine_design.coherent
    assert law is not None
    (loop,), _ = loop_points(turbine_design, [wind])
    gains = loop.controller
    assert isinstance(gains, LocalGains)
    nu = law.gain_pair(wind)[1] / law.gain_pair(wind)[0]
    step = 1e-6

    def command(speed: float, integral: float) -> np.ndarray:
        measured = Measurement(loop.point.rotor_speed + speed, loop.point.pitch, wind)
        return np.array(law.command([nu * integral, wind], measured))

    by_speed = (command(step, 0) - command(-step, 0)) / (2 * step)
    by_integral = (command(0, step) - command(0, -step)) / (2 * step)
    np.testing.assert_allclose(
        [gains.torque_by_speed, gains.pitch_by_speed], by_speed, rtol=1e-5, atol=1e-4
    )
    np.testing.assert_allclose(
        [gains.torque_by_integral, gains.pitch_by_integral], by_integral, rtol=1e-5, atol=1e-4
    )


def test_the_linear_loop_rests_where_the_law_rests(turbine_design: TurbineDesign) -> None:
    """At the loop's trim the law asks for exactly the trim's torque and pitch."""
    law = turbine_design.coherent
    assert law is not None
    for loop in loop_points(turbine_design, [5.0, 11.45, 20.0])[0]:
        point = loop.point
        command = law.command(
            [0.0, point.wind], Measurement(point.rotor_speed, point.pitch, point.wind)
        )
        assert command.torque == pytest.approx(point.torque, rel=1e-12)
        assert command.pitch == pytest.approx(point.pitch, abs=1e-12)


def test_proved_decay_is_below_the_poles(turbine_design: TurbineDesign) -> None:
    """The certified decay of a cell is no faster than the slowest pole at a wind inside it."""
    summary = claim_summary(turbine_design)
    assert summary is not None
    winds = [math.fsum(cell) / 2 for cell in summary.winds]
    loops, _ = loop_points(turbine_design, winds)

    poles = closed_loop_poles(
        turbine_design.turbine, [p.point for p in loops], [p.controller for p in loops],
        kind="design",
    )  # fmt: skip

    for found, decay, fine in zip(poles, summary.decay_rates, summary.proved, strict=True):
        assert not fine or decay <= -found.real.max()


@pytest.mark.slow
def test_a_paper_law_has_its_own_words(turbine_design: TurbineDesign) -> None:
    """With a published law the page shows its equation and claims, not those of the other law."""
    design = with_paper_law(turbine_design)

    box, law = text_of(verdict_section(design)), text_of(gains_section(design))

    assert claim_summary(design) is None
    assert "from 12 m/s" in box and "UNDECIDED" in box
    assert "4 × 4 × 8 = 128 rules" in law
    assert "stable" in text_of(poles_section(design))


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
    assert text in as_text(design)


def test_winds_beyond_the_claim_are_not_taken_as_proved() -> None:
    """Ranges that a text names are cut to the winds of the claim."""
    own = overlap_claims(overlap_design(GAP.replace("3 to 10.084124", "1 to 10.084124")))[0]

    assert own.proved[0] == (3.0, 10.084124)


def test_overlaps_are_a_picture_a_table_and_folded_words() -> None:
    """The verdict on a paper law: one figure, one row per claim, full texts to unfold, the gap."""
    section = verdict_section(overlap_design())
    box = text_of(section)
    page = _Page(box)

    assert [plate.name for plate in section.plates] == ["overlaps"]
    assert sum(1 for a in page.all("th") if a.get("scope") == "row") == 2
    assert page.wrong == [] and page.open == []
    shown, folded = box.split("<details>")
    assert "10.084 to 10.414 m/s with the overlaps 0.1 rad/s, 2000 N m" in shown
    assert "0.00233 to 0.0997" in shown and "551" not in shown
    assert "own &lt;overlaps&gt;" in folded and "551" in folded
    assert box == text_of(verdict_section(overlap_design()))


def test_terminal_tells_the_chosen_overlaps_and_lists_the_others() -> None:
    """A few lines on the law's own overlaps, one line on the others; no full text."""
    lines = as_text(overlap_design()).splitlines()

    assert lines[0] == "UNDECIDED  NREL 5-MW, law paper"
    assert lines[1].split() == "overlaps 0.1 rad/s, 2000 N m: UNDECIDED".split()
    assert "  not proved    10.084 to 10.414 m/s" in lines
    assert lines[-1] == "  PROVED  0.05 rad/s, 1000 N m  20 of 22 windows, from 3.5 to 22.5 m/s"
    assert lines[-2] == "Other overlaps, proved winds (windows 0.03 m/s wide)"
    assert max(map(len, lines)) < 110


def test_numbers_read_well() -> None:
    """True minus signs, no exponents where they hinder, bounds rounded to the safe side."""
    assert with_decimals(-0.0001, 2) == "0.00"
    assert with_decimals(float("inf"), 1) == "∞"
    assert significant(-2.2154e-6, 3) == "−2.22·10⁻⁶"
    assert significant(43093.55, 3) == "43094"
    assert at_most(3.5512, 2) == "3.56"
    assert at_most(8.0, 1) == "8.0"
    assert at_least(0.0039799) == "0.00397"
    assert at_least(0.004) == "0.00400"
    assert powers("m/s^2 and kg^-1") == "m/s² and kg⁻¹"
