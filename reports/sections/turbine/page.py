"""The report of a turbine's design: makes all sections and assembles the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from takagi.certificates.checker.kernel.result import Verdict
from takagi.models.laws.protocol import law_words
from takagi.reports.page.assembly import ReportFiles, report_files
from takagi.reports.page.text import Section

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

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
    from takagi.certificates.design.turbine.result import claim_summary
    from takagi.reports.sections.shared import check_section, provenance_section
    from takagi.reports.sections.turbine.cells import blending_section, cells_section, gains_section
    from takagi.reports.sections.turbine.model import (
        model_section,
        observer_section,
        regions_section,
    )
    from takagi.reports.sections.turbine.responses import responses_section
    from takagi.reports.sections.turbine.running import running_section
    from takagi.reports.sections.turbine.verdict import claims_section, verdict_section

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
