"""Simulations of the nonlinear plant under its law, from inside the ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.figures.plant.captioned import Drawn
from takagi.reports.loops.plant_motion import PlantMotion, settling_time
from takagi.reports.page.labels import name_of, unit_of
from takagi.reports.page.text import DASH, Section, Table, significant

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

# The tolerance of the integration may make V rise by this share of its first value.
SLACK = 1e-5
NOTHING = Drawn(())


def motion_section(
    loop: PlantLoop,
    shown: Sequence[PlantMotion],
    drawn: Drawn,
    jumps: Sequence[PlantMotion] = (),
    jumped: Drawn = NOTHING,
) -> Section:
    """Return the section with responses, planes of states and a table of figures.

    Parameters
    ----------
    jumps, jumped : motions after jumps of references, and their figures.
    """
    return Section(
        "responses",
        "Motions of the nonlinear plant",
        {
            "figures": list(drawn.captioned_figures),
            "jumps": list(jumped.captioned_figures),
            "table": _table(loop, [*shown, *jumps]),
            "lost": [motion.name for motion in (*shown, *jumps) if not motion.whole],
            "rising": [motion.name for motion in shown if _rises(motion)],
            "cut": cut_words(loop, [*shown, *jumps]),
            "valued": bool(shown and shown[0].value.size),
            "law": loop.gains is not None,
        },
    )


def cut_words(loop: PlantLoop, shown: Sequence[PlantMotion]) -> list[str]:
    """Return for each motion and input when its command was beyond the range, and for how long."""
    blended = () if loop.blend is None else loop.blend.blending.actuators
    variables = [*loop.plant.inputs, *(a.variable for a in blended)]
    found = []
    for motion in shown:
        for k, variable in enumerate(variables):
            cuts = [cut for cut in motion.cuts if cut.command == k]
            if cuts:
                spent, first = sum(cut.end - cut.begin for cut in cuts), cuts[0].begin
                found.append(
                    f"{variable.name} for {significant(spent)} s from {significant(first)} s on "
                    f"({motion.name})"
                )
    return found


def _rises(motion: PlantMotion) -> bool:
    """Return whether V grows by more than the integration's tolerance explains."""
    if motion.value.size < 2:
        return False
    return bool(np.any(np.diff(motion.value) > SLACK * motion.value[0]))


def _table(loop: PlantLoop, shown: Sequence[PlantMotion]) -> Table:
    inputs = [v.label for v in loop.plant.inputs] if loop.gains is not None else []
    columns = [
        ("start", ""),
        *((f"{name_of(label)} at start", unit_of(label)) for label in loop.model.states),
        ("settled to 1 %", "s"),
        *((f"{name_of(label)}, largest", unit_of(label)) for label in inputs),
    ]
    rows = []
    for motion in shown:
        time = settling_time(motion)
        largest = np.abs(motion.input).max(axis=0) if inputs else []
        rows.append(
            (
                motion.name,
                *(significant(float(x)) for x in motion.state[0]),
                DASH if np.isnan(time) else significant(time),
                *(significant(float(u)) for u in largest),
            )
        )
    return Table("The motions in figures", tuple(columns), tuple(rows))
