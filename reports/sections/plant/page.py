"""The report of a plant: makes all sections and assembles the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from takagi.reports.page.assembly import ReportFiles, report_files
from takagi.reports.page.text import Section

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign

Tell = Callable[[str], None]


def plant_report_files(
    design: PlantDesign, *, tell: Tell | None = None, timings: bool = True
) -> ReportFiles:
    """Return the page together with its figures; each figure is computed once.

    ``figures`` has SVG files, and CSV files with the numbers of motions and weights.

    Parameters
    ----------
    tell : called with a word before each section.
    timings : whether the page has the time of each step of the design; without the times the same
        design gives the same bytes.

    Raises
    ------
    ModelError : gains that do not fit the model.
    """
    say = tell or (lambda _: None)
    sections, data = _sections(design, say, timings=timings)
    kind = (
        "Design report: model, gains, certificate, margins, motions."
        if design.gains is not None
        else "Analysis report: model, certificate, poles, motions."
    )
    return report_files(
        "plant",
        sections,
        title=design.plant.name or "Plant",
        verdict=design.checked.verdict.name,
        subtitle=kind,
        units="SI units throughout; angles in rad unless marked.",
        styles=("style.css", "formulas.css"),
        data=data,
    )


def _sections(
    design: PlantDesign, say: Tell, *, timings: bool
) -> tuple[list[Section], dict[str, str]]:
    from takagi.reports.figures.plant.captioned import (
        captioned_jumps_figure,
        captioned_motion_figures,
        captioned_weights_figure,
    )
    from takagi.reports.loops.plant_local import local_loops
    from takagi.reports.loops.plant_loop import plant_loop
    from takagi.reports.loops.plant_motion import motions, starts
    from takagi.reports.sections.plant.blend import actuators_csv, blend_section
    from takagi.reports.sections.plant.certificate import certificate_section, set_section
    from takagi.reports.sections.plant.gains import gains_section
    from takagi.reports.sections.plant.loops import (
        loops_section,
        motion_section,
        poles_section,
        regulator_section,
    )
    from takagi.reports.sections.plant.plant import derivation_section, plant_section
    from takagi.reports.sections.plant.verdict import verdict_section
    from takagi.reports.sections.shared import check_section, provenance_section
    from takagi.reports.simulation.plant import jump_motions

    loop = plant_loop(design)
    say("report: margins")
    loops = local_loops(loop)
    say("report: motions")
    shown = motions(loop, starts(loop))
    moved = captioned_motion_figures(loop, shown)
    jumps = jump_motions(design, loop)
    jumped = captioned_jumps_figure(loop, jumps)
    say("report: derivation")
    weights = captioned_weights_figure(loop)
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
    say("report: LQR beside it")
    more = (set_section(design, loop), regulator_section(design, loop))
    found += [one for one in more if one is not None]
    say("report: figures")
    found.append(poles_section(loop))
    if loops:
        found.append(loops_section(loop, loops))
    found += [
        motion_section(loop, shown, moved, jumps, jumped),
        check_section(compared="the plant's file its", law=loop.gains is not None),
        provenance_section(design, timings=timings),
    ]
    return found, {**weights.data, **blended, **moved.data, **jumped.data}
