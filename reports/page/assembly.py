"""One page from its sections: each fills its template, and all figures are collected as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from takagi.reports.page.text import Section, decimal, powers, significant, typeset, with_decimals

if TYPE_CHECKING:
    from jinja2 import Environment

# A room's own templates go before those that all pages share.
TEMPLATES = ("takagi.reports.sections.{}.templates", "takagi.reports.page.templates")


@dataclass(frozen=True, slots=True)
class ReportFiles:
    """The report: ``html``, the page's text; ``figures``, file name -> SVG, or CSV beside it."""

    html: str
    figures: Mapping[str, bytes]


def report_files(
    room: str,
    sections: Sequence[Section],
    *,
    title: str,
    verdict: str,
    subtitle: str,
    units: str,
    styles: Sequence[str] = ("style.css",),
    data: Mapping[str, str] | None = None,
) -> ReportFiles:
    """Return one self-contained page of all sections, and their figures as files.

    room : of the sections, "turbine" or "plant".
    units : what the footer says about units.
    styles : style sheets of the page, one after the other.
    data : file name -> text of the numbers behind the figures.
    """
    html = (
        _environment(room)
        .get_template("page.html.jinja")
        .render(
            title=title,
            verdict=verdict,
            subtitle=subtitle,
            units=units,
            style="".join(_read(room, name) for name in styles),
            sections=[(section, render(section, room)) for section in sections],
        )
    )
    figures = {
        f"{captioned.name}.svg": captioned.file
        for section in sections
        for captioned in section.captioned_figures
    }
    figures |= {name: text.encode("utf-8") for name, text in (data or {}).items()}
    return ReportFiles(html, figures)


def render(section: Section, room: str) -> str:
    """Return the section's HTML, without its heading."""
    template = _environment(room).get_template(f"{section.anchor}.html.jinja")
    return template.render(section.content)


@cache
def _environment(room: str) -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(lambda name: _read(room, name)),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        powers=powers,
        typeset=typeset,
        decimal=lambda value: decimal(float(value)),
        places=lambda value, digits: with_decimals(float(value), digits),
        significant=lambda value, digits=3: significant(float(value), digits),
    )
    return environment


def _read(room: str, name: str) -> str:
    room_file, shared = (
        resources.files(package.format(room)).joinpath(name) for package in TEMPLATES
    )
    return (room_file if room_file.is_file() else shared).read_text(encoding="utf-8")
