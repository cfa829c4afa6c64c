"""The report of a turbine's design: its first screen, the table of claims, and the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.operation import OverlapRow, overlaps_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.kinds_in_words import KINDS_IN_WORDS
from takagi.reports.loops.plant_claims import OverlapClaim, overlap_claims, wind_words
from takagi.reports.page.assembly import (
    ReportFiles,
    check_section,
    provenance_section,
    report_files,
)
from takagi.reports.page.text import CaptionedFigure, Section
from takagi.reports.sections.plant.summary import SummaryRow
from takagi.reports.sections.turbine.model import (
    blending_section,
    cells_section,
    gains_section,
    gust_figure,
    model_section,
    observer_section,
    regions_section,
)
from takagi.reports.sections.turbine.running import responses_section, running_section
from takagi.reports.sections.turbine.summary import summary_rows, summary_sentence
from takagi.reports.simulation.measured_loop import in_wind_class, measured_loop

# Name of a tile -> the rows that it shows, each with so many of its parts.
TILES = {
    "rotor speed": (("rotor speed", 3),),
    "proved winds": (("proved winds", 2),),
    "overspeed": (("overspeed", 3),),
    "wind limits": (("turbulence", 2),),
    "settling": (("settling", 2), ("observer", 1)),
    "worst margin": (("margins", 2),),
    "not covered": (("not covered", 5),),
}


def verdict_section(design: TurbineDesign) -> Section:
    """Return the first screen of a turbine's report."""
    rows = {row.name: row for row in summary_rows(design)}
    tiles = [
        _tile(name, [(rows[r], n) for r, n in counts if r in rows])
        for name, counts in TILES.items()
    ]
    return Section(
        "verdict",
        "The answer",
        {
            "verdict": design.checked.verdict.name,
            "sentence": summary_sentence(design),
            "tiles": [tile for tile in tiles if tile.parts],
            "picture": _picture(design),
            "setpoint": design.settings.speed_setpoint,
        },
    )


def _tile(name: str, rows: list[tuple[SummaryRow, int]]) -> SummaryRow:
    phrases = [
        phrase if k == 0 else f"{row.name}: {phrase}"
        for k, (row, count) in enumerate(rows)
        for phrase in row.parts[:count]
    ]
    amber = [row.shortfall for row, _ in rows if row.partial]
    basis = dict.fromkeys(row.basis or "proved" for row, _ in rows)
    beside = [row.regulator for row, _ in rows if row.regulator]
    return SummaryRow(
        name,
        tuple(phrases),
        regulator=", ".join(beside),
        basis=", ".join(basis),
        partial=bool(amber),
        shortfall=", ".join(amber),
    )


def _picture(design: TurbineDesign) -> CaptionedFigure | None:
    """Return the gust at rated wind with proved and simulated speed; or what is proved by wind."""
    if overlaps := overlap_claims(design):
        return _overlap_figure(design, overlaps)
    run, summary = measured_loop(design).drawn.get("gust"), claim_summary(design)
    if run is None or run.law.line is None:
        return None
    inside = in_wind_class(design, run.time, run.law.line.wind, run.schedule)
    bound = None
    if summary is not None and summary.verdict is Verdict.PROVED:
        bound = (1 + summary.overspeed) * design.turbine.rated_rotor_speed
    words = "IEC gust at rated wind, simulated."
    if bound:
        words += " Grey: outside the proved wind limits"
    law = design.effort_sharing_law
    if bound and law is not None:
        words += ", until the schedule wind, the wind through the law's filter of "
        words += f"{law.wind_filter:g} s, is close to the wind again."
    return captioned_figure(gust_figure(run, bound, inside), "gust", words=words)


def claims_section(design: TurbineDesign) -> Section:
    """Return the section with the claims, their assumptions, and what none of them covers."""
    summary = claim_summary(design)
    content: dict[str, Any] = {"rows": _claim_rows(design), "summary": summary, "unproved": []}
    if summary is not None:
        content["unproved"] = [
            f"{low:g} to {high:g} m/s"
            for (low, high), fine in zip(summary.winds, summary.proved, strict=True)
            if not fine
        ]
    return Section("claims", "What is proved", content)


def _claim_rows(design: TurbineDesign) -> list[dict[str, str]]:
    """Return one row for each claim, with the figures that follow from it."""
    figures: dict[str, list[str]] = {}
    for row in summary_rows(design):
        figures.setdefault(row.claim, []).append(f"{row.name}: {', '.join(row.parts)}")
    overlaps = {claim.name: claim for claim in overlap_claims(design)}
    figures |= {name: _overlap_figures(claim) for name, claim in overlaps.items()}
    rows = []
    for stated, checked in zip(design.document["claims"], design.checked.claims, strict=True):
        words = KINDS_IN_WORDS[stated["kind"]]
        proved = checked.verdict is Verdict.PROVED
        figure_text = "; ".join(figures.get(checked.name, [])) or "see the checker's words"
        overlap = overlaps.get(checked.name)
        rows.append(
            {
                "name": words.name + (f", overlaps {overlap.label}" if overlap else ""),
                "verdict": checked.verdict.name,
                "number": figure_text if proved or (overlap and overlap.proved) else checked.text,
                "assumes": _assumed(checked, design.checked.claims[0]),
                "why": words.why,
                "text": f"{checked.name}: {checked.text}",
            }
        )
    return rows


def _overlap_figures(claim: OverlapClaim) -> list[str]:
    """Return the proved winds of a claim and the bounds that hold there; [] without any."""
    if not claim.proved:
        return []
    return [
        f"proved winds: {wind_words(claim)}",
        f"decay rate at least {' to '.join(claim.decay)} 1/s, by wind",
        f"speed within {claim.speed_share} % of rated from its reference, from sets of up to "
        f"{claim.half_width} rad/s",
    ]


def _assumed(claim: Claim, first: Claim) -> str:
    """Return the assumptions of a claim, those of the first claim in short."""
    phrases = list(claim.assumes)
    if claim is not first and first.assumes and set(first.assumes) <= set(phrases):
        phrases = [phrase for phrase in phrases if phrase not in first.assumes]
        phrases.insert(0, "what the first claim assumes")
    return "; ".join(phrases) or "nothing beside the file"


def _overlap_figure(design: TurbineDesign, claims: tuple[OverlapClaim, ...]) -> CaptionedFigure:
    turbine = design.turbine
    rows = [OverlapRow(claim.label, claim.proved, claim.unproved) for claim in claims]
    winds_by_overlap = "; ".join(f"{claim.label}: {wind_words(claim)}" for claim in claims)
    return captioned_figure(
        overlaps_figure(rows, wind=(turbine.cut_in, turbine.cut_out)),
        "overlaps",
        winds=winds_by_overlap,
    )


Tell = Callable[[str], None]


def report_html(design: TurbineDesign, *, tell: Tell | None = None) -> ReportFiles:
    """Return the report of a design: one self-contained page, and its figures as files.

    The same design gives the same bytes.  ``tell`` is called with a word before each section.
    """
    claims = design.checked.claims
    proved = sum(claim.verdict is Verdict.PROVED for claim in claims)
    sections = []
    for name, make in _makers(design).items():
        if tell is not None:
            tell(f"report: {name}")
        sections.append(make())
    return report_files(
        "turbine",
        sections,
        title=f"{design.turbine.name}: {law_words(design.law.name)}",
        verdict=design.checked.verdict.name,
        subtitle=f"Design report, {proved} of {len(claims)} claims proved",
        units="SI units; angles in the tables of the law in rad, elsewhere in degrees where "
        "marked. Torque on the high-speed shaft.",
    )


def _makers(design: TurbineDesign) -> dict[str, Callable[[], Section]]:
    summary = claim_summary(design)
    # The law's own models and gains alone: regions and their filter belong to Schulte's law.
    of_law = {
        "regional models": lambda: regions_section(design),
        "blending": lambda: blending_section(design),
    }
    of_set = {} if summary is None else {"cells": lambda: cells_section(design, summary)}
    return {
        "answer": lambda: verdict_section(design),
        "law and gains": lambda: gains_section(design),
        **({} if design.effort_sharing_law else of_law),
        "turbine": lambda: model_section(design),
        "claims": lambda: claims_section(design),
        **of_set,
        "margins": lambda: running_section(design),
        "responses": lambda: responses_section(design),
        "wind observer": lambda: observer_section(design),
        "how to check": lambda: check_section(
            compared="the turbine's data file the plant's",
            needs="; it needs Python's standard library alone",
        ),
        "provenance": lambda: provenance_section(design),
    }
