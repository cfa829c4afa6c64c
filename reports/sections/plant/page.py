"""The report of a plant: every section made, filled into its template, and put together."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from takagi.reports.output import write_folder
from takagi.reports.page.text import Section, powers
from takagi.reports.sections.turbine.page import ReportFiles

if TYPE_CHECKING:
    from jinja2 import Environment

    from takagi.certificates.design.plant.design import PlantDesign

__all__ = ["plant_figures", "plant_report", "plant_report_files"]

Tell = Callable[[str], None]
# A template of this package goes before one of the turbine's report with the same name.
TEMPLATES = ("takagi.reports.sections.plant.templates", "takagi.reports.sections.turbine.templates")
SVG_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'


def plant_report(design: PlantDesign) -> str:
    """Return the report as one self-contained HTML page, readable without JavaScript."""
    return plant_report_files(design).html


def plant_figures(design: PlantDesign, folder: str | Path) -> Path:
    """Write the report's figures (SVG) and their data (CSV) into ``folder``; return the folder.

    Raises
    ------
    OutputError : the folder cannot be written.
    """
    return write_folder(Path(folder), plant_report_files(design).figures)


def plant_report_files(
    design: PlantDesign, *, tell: Tell | None = None, timings: bool = True
) -> ReportFiles:
    """Return page and figures together, each computed once.

    ``figures`` has SVG files and, beside them, CSV files with the numbers of motions and weights.

    Parameters
    ----------
    tell : called with a word before each section.
    timings : whether the page says how long each step of the design took; without, the same
        design gives the same bytes.

    Raises
    ------
    ModelError : gains that do not fit the model.
    """
    say = tell or _silent
    sections, data = _sections(design, say, timings=timings)
    name = design.plant.name or "Plant"
    html = (
        _environment()
        .get_template("plant_page.html.jinja")
        .render(
            title=name,
            verdict=design.checked.verdict.name,
            law=design.gains is not None,
            style=_read("style.css") + _read("plant.css"),
            sections=[(section, _rendered(section)) for section in sections],
        )
    )
    figures: dict[str, bytes] = {
        f"{plate.name}.svg": (SVG_HEAD + plate.svg).encode("utf-8")
        for section in sections
        for plate in section.plates
    }
    figures |= {file: text.encode("utf-8") for file, text in data.items()}
    return ReportFiles(html, figures)


def _sections(
    design: PlantDesign, say: Tell, *, timings: bool
) -> tuple[list[Section], dict[str, str]]:
    from takagi.reports.figures.plant.captioned import motion_plates, weights_plate
    from takagi.reports.loops.plant_local import local_loops
    from takagi.reports.loops.plant_loop import plant_loop
    from takagi.reports.loops.plant_motion import motions, starts
    from takagi.reports.sections.plant.blend import actuators_csv, blend_section
    from takagi.reports.sections.plant.certificate import certificate_section
    from takagi.reports.sections.plant.derivation import derivation_section
    from takagi.reports.sections.plant.gains import gains_section
    from takagi.reports.sections.plant.loops import loops_section, poles_section
    from takagi.reports.sections.plant.motion import motion_section
    from takagi.reports.sections.plant.plant import plant_section
    from takagi.reports.sections.plant.verdict import verdict_section
    from takagi.reports.sections.turbine.provenance import provenance_section

    loop = plant_loop(design)
    say("report: margins")
    loops = local_loops(loop)
    say("report: motions")
    shown = motions(loop, starts(loop))
    moved = motion_plates(loop, shown)
    say("report: derivation")
    weights = weights_plate(loop)
    found = [
        verdict_section(design, loop, loops),
        plant_section(design),
        derivation_section(design, weights),
    ]
    blended: dict[str, str] = {}
    if loop.blend is not None:
        found.append(blend_section(loop, loop.blend))
        blended["actuators.csv"] = actuators_csv(loop.blend, loop)
    if loop.gains is not None:
        found.append(gains_section(design, loop))
    found.append(certificate_section(design, loop))
    say("report: figures")
    found.append(poles_section(loop))
    if loops:
        found.append(loops_section(loop, loops))
    found += [
        motion_section(loop, shown, moved),
        Section("check", "How to check it", {"law": loop.gains is not None}),
        provenance_section(design, timings=timings),
    ]
    return found, {**weights.data, **blended, **moved.data}


def _rendered(section: Section) -> str:
    """Return the section's HTML, without its heading."""
    anchor = section.anchor
    name = f"{anchor}.html.jinja" if anchor == "provenance" else f"plant_{anchor}.html.jinja"
    return _environment().get_template(name).render(section.content)


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
    for package in TEMPLATES:
        place = resources.files(package).joinpath(name)
        if place.is_file():
            return place.read_text(encoding="utf-8")
    raise FileNotFoundError(f"template {name} lies in none of {', '.join(TEMPLATES)}")


def _silent(_: str) -> None:
    """Say nothing."""
