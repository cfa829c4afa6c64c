"""One page from its sections: each fills its template, and all figures are collected as files."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from takagi.reports.page.text import (
    Section,
    Table,
    decimal,
    powers,
    significant,
    table,
    typeset,
    with_decimals,
)

if TYPE_CHECKING:
    from jinja2 import Environment

    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.ts.model import TSModel
    from takagi.reports.margins.margins import Margins

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

    Parameters
    ----------
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


def premise_table(model: TSModel, caption: str, evidence: str) -> Table:
    """Return the premises of a model with their proved ranges.

    ``evidence`` is the heading of the last column, which says how a range was bounded.
    """
    rows = ((p.name, decimal(float(p.lower)), decimal(float(p.upper)), p.unit, p.evidence)
            for p in model.premises)  # fmt: skip
    return table("premises", rows, premises=caption, evidence=evidence)


def margin_table(rows: Iterable[tuple[tuple[str, ...], Margins]], *, folded_from: int) -> Table:
    """Return a table of the margins of (place, loop); folded with more than so many rows."""
    table_rows = [(*head, *_cells(margins)) for head, margins in rows]
    return table("margins", table_rows, folded=len(table_rows) > folded_from)


def _cells(m: Margins) -> tuple[str, ...]:
    if not m.stable:
        return ("unstable",) * 8
    down = 20 * math.log10(m.gain_decrease) if m.gain_decrease > 0 else -math.inf
    return (
        significant(m.crossover),
        with_decimals(20 * math.log10(m.gain_increase), 1),
        with_decimals(down, 1),
        with_decimals(math.degrees(m.phase), 0),
        significant(m.delay),
        with_decimals(20 * math.log10(m.disk.gain_increase), 1),
        with_decimals(math.degrees(m.disk.phase), 0),
        with_decimals(m.sensitivity_peak, 2),
    )


def check_section(*, compared: str, law: bool = True, needs: str = "") -> Section:
    """Return the section that says how to check the certificate.

    Parameters
    ----------
    compared : words (HTML) before "hash" that name the file whose hash is also compared.
    law : whether there is a gain file for the certificate.
    needs : a further remark on the checker (HTML).
    """
    return Section("check", "How to check it", {"compared": compared, "law": law, "needs": needs})


def provenance_section(design: TurbineDesign | PlantDesign) -> Section:
    """Return versions, hashes and configuration."""
    recorded = design.document["provenance"]
    files = recorded.get("files_sha256", {})
    hashes = [(f"certificate: {name}", value) for name, value in recorded["sha256"].items()]
    hashes += [(f"file: {name}", value) for name, value in files.items()]
    versions = tuple((name, str(value)) for name, value in recorded["versions"].items())
    return Section(
        "provenance",
        "Provenance",
        {
            "versions": table("versions", versions),
            "hashes": table("hashes", hashes),
            "solver": {k: words for k, words in recorded.get("solver", {}).items() if words},
            "configuration": json.dumps(recorded.get("configuration", {}), indent=1),
        },
    )
