"""The claims one by one; and the proved set in pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.plant.plant import file_unit, time_in_file_units
from takagi.reports.figures.plant.proved_set import MOST_STATES, pairs, set_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.linear_quadratic import regulator
from takagi.reports.loops.plant_claims import SETTLED, half_widths, overshoots, settling_time
from takagi.reports.loops.plant_loop import embedded
from takagi.reports.page.rounded_bounds import at_least, at_most
from takagi.reports.page.text import DASH, Section, Table, decimal
from takagi.reports.sections.plant.claims import claim_rows

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.arrays import Floats
    from takagi.reports.loops.plant_loop import PlantLoop


def certificate_section(design: PlantDesign, loop: PlantLoop) -> Section:
    """Return the section with each claim, and what none of them covers."""
    return Section(
        "certificate",
        "What is proved, claim by claim",
        {
            "claims": claim_rows(design, loop),
            "embedded": embedded(design),
            "law": loop.gains is not None,
            "measured": list(design.plant.measured or ()),
            "disturbances": [v.name for v in design.plant.disturbances if not v.schedules],
            "signals": [v.name for v in design.plant.disturbances if v.schedules],
            "discrete": loop.discrete,
            "tried": list(design.certificate.tried),
            "level_proved": loop.level_proved,
        },
    )


COLUMNS = (
    ("state", ""), ("unit", ""), ("safe start, others at rest", ""), ("never beyond", ""),
    ("range in the file", ""), ("overshoot, at most times", ""), ("safe start under LQR", ""),
)  # fmt: skip


def set_section(design: PlantDesign, loop: PlantLoop) -> Section | None:
    """Return the section; None where no set is proved to be invariant."""
    reach = half_widths(loop)
    if reach is None:
        return None
    beside = regulator(design)
    regulator_starts = None if beside is None else beside.starts
    captioned_figures = []
    # Of two states the first screen has the picture.
    if len(pairs(loop)) > 1:
        captioned_figures.append(
            captioned_figure(
                set_figure(loop),
                "set",
                caption="The proved set in the plane of every pair of states, as deviations from "
                "rest in the units of the file. Filled: starts at which all other states are at "
                "rest. Dashed: the projection of the whole set, which no motion from it leaves. "
                "Dotted: the box, where it is near.",
                alternative="Ellipses of the proved set for every pair of states, with the box",
            )
        )
    rows = _rows(design, loop, reach, regulator_starts)
    # A column without a figure is left out.
    columns = [k for k in range(len(COLUMNS)) if any(row[k] != DASH for row in rows)]
    time = settling_time(loop)
    settled = ""
    if time is not None:
        number, unit = time_in_file_units(loop.plant, time)
        settled = f"{at_most(number)} {unit}"
    return Section(
        "set",
        "The safe set",
        {
            "table": Table(
                "Half-widths of the set, deviations from rest",
                tuple(COLUMNS[k] for k in columns),
                tuple(tuple(row[k] for k in columns) for row in rows),
            ),
            "overshoot": 5 in columns,
            "none_beside": beside is not None and beside.sought and regulator_starts is None,
            "figures": captioned_figures,
            "left_out": max(len(loop.names) - MOST_STATES, 0) if captioned_figures else 0,
            "settled": settled,
            "share": f"{SETTLED:.0%}",
            "observed": loop.observed is not None,
        },
    )


def _rows(
    design: PlantDesign, loop: PlantLoop, reach: Floats, regulator_starts: Floats | None
) -> tuple[tuple[str, ...], ...]:
    P, level = loop.start_ellipsoid
    alone = np.sqrt(level / np.diag(P))
    beyond = overshoots(design, loop)
    count = len(loop.names) - len(loop.plant.integrators)
    rows = []
    for k, (name, variable) in enumerate(zip(loop.names, loop.plant.states, strict=True)):
        size, unit = file_unit(variable)
        ends = loop.model.box.get(loop.model.states[k])
        box = DASH
        if ends is not None:
            low, high = (decimal(float(f"{float(end) / size:.6g}")) for end in ends)
            box = f"{low} to {high}"
        rows.append(
            (
                name,
                unit,
                f"±{at_least(float(alone[k]) / size)}" if k < count else DASH,
                f"±{at_most(float(reach[k]) / size, 4)}",
                box,
                at_most(beyond[name]) if name in beyond else DASH,
                DASH
                if regulator_starts is None
                else f"±{at_least(float(regulator_starts[k]) / size)}",
            )
        )
    return tuple(rows)
