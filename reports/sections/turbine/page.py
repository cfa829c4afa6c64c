"""The page: every section made, filled into its template, and put together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from takagi.reports.page.text import Section, powers

if TYPE_CHECKING:
    from jinja2 import Environment

    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["ReportFiles", "render", "report_html"]

Tell = Callable[[str], None]
TEMPLATES = "takagi.reports.sections.turbine.templates"
SVG_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'


@dataclass(frozen=True, slots=True)
class ReportFiles:
    """The report: ``html``, the page's text; ``figures``, file name -> SVG."""

    html: str
    figures: Mapping[str, bytes]


def report_html(
    design: TurbineDesign, *, tell: Tell | None = None, timings: bool = True
) -> ReportFiles:
    """Return the report of a design: one self-contained page, and its figures as files.

    Parameters
    ----------
    tell : called with a word before each section.
    timings : whether the page says how long each step of the design took; without, the same
        design gives the same bytes.
    """
    sections = []
    for name, make in _makers(design, timings=timings).items():
        if tell is not None:
            tell(f"report: {name}")
        sections.append(make())
    html = (
        _environment()
        .get_template("page.html.jinja")
        .render(
            title=f"{design.turbine.name}: {design.law.name} law",
            verdict=design.checked.verdict.name,
            style=_read("style.css"),
            sections=[(section, render(section)) for section in sections],
        )
    )
    figures = {
        f"{plate.name}.svg": (SVG_HEAD + plate.svg).encode("utf-8")
        for section in sections
        for plate in section.plates
    }
    return ReportFiles(html, figures)


def render(section: Section) -> str:
    """Return the section's HTML, without its heading."""
    template = _environment().get_template(f"{section.anchor}.html.jinja")
    return template.render(section.content)


def _makers(design: TurbineDesign, *, timings: bool) -> dict[str, Callable[[], Section]]:
    from takagi.reports.sections.turbine.blending import blending_section
    from takagi.reports.sections.turbine.cells import cells_section
    from takagi.reports.sections.turbine.gains import gains_section
    from takagi.reports.sections.turbine.loops import loops_section, poles_section
    from takagi.reports.sections.turbine.model import model_section
    from takagi.reports.sections.turbine.observer import observer_section
    from takagi.reports.sections.turbine.provenance import check_section, provenance_section
    from takagi.reports.sections.turbine.regions import regions_section
    from takagi.reports.sections.turbine.responses import responses_section
    from takagi.reports.sections.turbine.verdict import verdict_section

    return {
        "verdict": lambda: verdict_section(design),
        "turbine": lambda: model_section(design),
        "regional models": lambda: regions_section(design),
        "law and gains": lambda: gains_section(design),
        "blending": lambda: blending_section(design),
        "certificate": lambda: cells_section(design),
        "poles": lambda: poles_section(design),
        "Bode plots and margins": lambda: loops_section(design),
        "responses": lambda: responses_section(design),
        "wind observer": lambda: observer_section(design),
        "how to check": lambda: check_section(design),
        "provenance": lambda: provenance_section(design, timings=timings),
    }


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(_read),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["powers"] = powers
    return environment


def _read(name: str) -> str:
    return resources.files(TEMPLATES).joinpath(name).read_text(encoding="utf-8")
