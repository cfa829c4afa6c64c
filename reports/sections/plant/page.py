"""The report of a plant: its first screen; all sections are made and the page is assembled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.plant.result import PlantDesign
from takagi.reports.figures.plant.captioned import (
    captioned_jumps_figure,
    captioned_motion_figures,
    captioned_picture,
    captioned_weights_figure,
)
from takagi.reports.loops.plant_local import local_loops, regulator, regulator_loop
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.loops.plant_motion import motions, starts
from takagi.reports.page.assembly import (
    ReportFiles,
    check_section,
    provenance_section,
    report_files,
)
from takagi.reports.page.text import CaptionedFigure, Section, at_least
from takagi.reports.sections.plant.claims import certificate_section, set_section
from takagi.reports.sections.plant.gains import (
    blend_section,
    derivation_section,
    gains_section,
    plant_section,
)
from takagi.reports.sections.plant.loops import loops_section, motion_section
from takagi.reports.sections.plant.summary import (
    ALL_OF_RANGE,
    SummaryRow,
    answer_sentence,
    summary_rows,
)
from takagi.reports.simulation.plant import jump_motions

Tell = Callable[[str], None]


def plant_report_files(design: PlantDesign, *, tell: Tell | None = None) -> ReportFiles:
    """Return the page together with its figures; each figure is computed once.

    ``figures`` has SVG files, and CSV files with the numbers of motions and weights.  The same
    design gives the same bytes.  ``tell`` is called with a word before each section.

    Raises
    ------
    ModelError : gains that do not fit the model.
    """
    say = tell or (lambda _: None)
    sections, data = _sections(design, say)
    kind = "Design report" if design.gains is not None else "Analysis report"
    claims = design.checked.claims
    proved = sum(claim.verdict is Verdict.PROVED for claim in claims)
    return report_files(
        "plant",
        sections,
        title=design.plant.name or "Plant",
        verdict=design.checked.verdict.name,
        subtitle=f"{kind}, {proved} of {len(claims)} claims proved",
        units="SI units throughout; angles in rad unless marked.",
        styles=("style.css", "formulas.css"),
        data=data,
    )


def _sections(design: PlantDesign, say: Tell) -> tuple[list[Section], dict[str, str]]:
    loop = plant_loop(design)
    say("report: margins")
    loops = local_loops(loop)
    say("report: motions")
    simulated = motions(loop, starts(loop))
    drawn_motions, picture = captioned_motion_figures(loop, simulated), captioned_picture(loop)
    beside = regulator(design)
    regulator_motions = (
        () if beside is None else motions(regulator_loop(loop, beside), starts(loop))
    )
    jumps = jump_motions(design, loop)
    jumped = captioned_jumps_figure(loop, jumps)
    weights = captioned_weights_figure(loop)
    # Of one state there is no plane: its responses are the picture.
    pictured = [*picture.captioned_figures, *drawn_motions.captioned_figures]
    if not picture.captioned_figures:
        drawn_motions = drawn_motions._replace(captioned_figures=())
    sections = [verdict_section(design, pictured[0])]
    if loop.gains is not None:
        sections.append(gains_section(design, loop))
    sections.append(certificate_section(design, loop))
    safe = set_section(design, loop)
    sections += [] if safe is None else [safe]
    say("report: figures")
    if loops:
        sections.append(loops_section(design, loop, loops))
    sections += [
        motion_section(loop, simulated, drawn_motions, jumps, jumped, regulator_motions),
        plant_section(design),
        derivation_section(design, weights),
    ]
    if loop.blend is not None:
        sections.append(blend_section(loop, loop.blend))
    sections += [
        check_section(compared="the plant's file its", law=loop.gains is not None),
        provenance_section(design),
    ]
    return sections, {**weights.data, **picture.data, **drawn_motions.data, **jumped.data}


# Row of the summary -> what its tile says where the design has no such row.
TILES = {
    "settles": "no rate is proved",
    "safe start": "no set is proved",
    "disturbance": "the file has none",
    "input": "no bound",
    "margins": "there is no loop",
    "not covered": "",
}
PART = {"follows": "the steps of ", "disturbance": "a varying "}  # before what is proved in part


def verdict_section(design: PlantDesign, picture: CaptionedFigure | None) -> Section:
    """Return the first screen of a plant's report."""
    rows = {row.name: row for row in summary_rows(design)}
    tiles = []
    for name, absent in TILES.items():
        row = rows.get(name)
        if row is None:
            ranged = any(state in design.model.box for state in design.model.states)
            tiles.append(SummaryRow(name, (absent,), partial=ranged and name == "safe start"))
        else:
            parts = row.parts
            if name == "safe start" and "polynomial" in rows:
                parts = (*parts, f"by a polynomial: {rows['polynomial'].parts[0]}")
            tiles.append(replace(row, parts=parts, basis=row.basis or "proved"))
    content = {
        "verdict": design.checked.verdict.name,
        "sentence": answer_sentence(design),
        "tiles": tiles,
        "picture": picture,
        "parts": [
            f"{at_least(100 * number.share, 2)} % of {PART.get(row.name, '')}{number.quantity}"
            for row in rows.values()
            for number in row.numbers
            if row.partial and number.share is not None and number.share < ALL_OF_RANGE
        ],
        "messages": list(design.checked.messages),
    }
    return Section("verdict", "The answer", content)
