"""The loops at rest: poles and margins, an LQ regulator to compare with, and simulated motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.plant.file_units import file_unit, time_in_file_units
from takagi.reports.figures.plant.captioned import (
    Drawn,
    captioned_bode_figures,
    captioned_poles_figure,
)
from takagi.reports.figures.plant.poles import equilibrium_poles
from takagi.reports.loops.linear_quadratic import MOST_RULES, MOST_STATES, Regulator, regulator
from takagi.reports.loops.plant_claims import SETTLED
from takagi.reports.loops.plant_local import LISTED, PlantLocalLoop
from takagi.reports.loops.plant_motion import PlantMotion, settling_time
from takagi.reports.page.rounded_bounds import at_least
from takagi.reports.page.text import (
    DASH,
    Section,
    Table,
    behind,
    complex_words,
    name_of,
    significant,
    unit_of,
)
from takagi.reports.sections.plant.gains import gain_columns
from takagi.reports.sections.shared import margin_table
from takagi.reports.simulation.plant_scenario import cuts_by_command

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

FOLDED = 8


def poles_section(loop: PlantLoop) -> Section:
    """Return the section with the poles of vertices and of the plant at rest."""
    alone, closed = equilibrium_poles(loop)
    return Section(
        "poles",
        "Poles",
        {
            "figure": captioned_poles_figure(loop),
            "alone": ", ".join(complex_words(alone)),
            "closed": ", ".join(complex_words(closed)),
            "discrete": loop.discrete,
        },
    )


def loops_section(loop: PlantLoop, loops: Sequence[PlantLocalLoop]) -> Section:
    """Return the section with Bode plots and margins; only for a plant with a law."""
    return Section(
        "loops",
        "Bode plots and margins",
        {
            "figures": list(captioned_bode_figures(loops)),
            "table": margin_table(
                "Margins of the linear loops",
                (("place", ""), ("loop", "")),
                [((one.place, name_of(one.input)), one.margins) for one in loops],
                down=True,
                folded_from=FOLDED,
            ),
            "unstable": [
                f"{one.place}, {name_of(one.input)}" for one in loops if not one.margins.stable
            ],
            "left_out": 0 if len(loop.model.rules) <= LISTED else len(loop.model.rules),
            "discrete": loop.discrete,
            "inputs": len(loop.model.inputs),
        },
    )


COLUMNS = (("", ""), ("unit", ""), ("this law at rest", ""), ("LQR", ""))


def regulator_section(design: PlantDesign, loop: PlantLoop) -> Section | None:
    """Return the section; None where there is no regulator to compare with."""
    found = regulator(design)
    if found is None:
        return None
    sizes = [
        *zip(loop.plant.states, found.states, strict=True),
        *zip(loop.plant.inputs, found.inputs, strict=True),
    ]
    weights = [
        f"{v.name}: {significant(float(size) / file_unit(v)[0])}{behind(file_unit(v)[1])}"
        for v, size in sizes
    ]
    return Section(
        "lqr",
        "Beside a linear-quadratic regulator",
        {
            "weights": weights,
            "table": Table("This law and LQR where the plant rests", COLUMNS, _rows(loop, found)),
            "poles": ", ".join(complex_words(found.own_poles)),
            "others": ", ".join(complex_words(found.poles)),
            "sought": found.sought,
            "proved": found.starts is not None,
            "most": (MOST_RULES, MOST_STATES),
        },
    )


def _rows(loop: PlantLoop, found: Regulator) -> tuple[tuple[str, ...], ...]:
    heads = gain_columns(loop)[-found.gain.size :]
    pairs = zip(heads, found.own_gain.ravel(), found.gain.ravel(), strict=True)
    rows: list[tuple[str, ...]] = [
        (f"gain, {name}", unit, significant(float(own), 4), significant(float(other), 4))
        for (name, unit), own, other in pairs
    ]
    step = loop.model.sample_time
    times = [found.settling(own=own, step=step) for own in (True, False)]
    shown = [None if time is None else time_in_file_units(loop.plant, time) for time in times]
    rows.append(
        (
            f"slowest mode at rest falls to {SETTLED:.0%} in",
            "",
            *(DASH if t is None else f"{significant(t[0])} {t[1]}" for t in shown),
        )
    )
    own = None
    if loop.bounded and loop.level_proved:
        P, level = loop.ellipsoid
        own = np.sqrt(level / np.diag(P))
    for k, variable in enumerate(loop.plant.states):
        size, unit = file_unit(variable)
        ends = [
            DASH if one is None else f"±{at_least(float(one[k]) / size)}"
            for one in (own, found.starts)
        ]
        rows.append((f"proved start of {name_of(loop.names[k])} alone", unit, *ends))
    return tuple(rows)


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
    found = []
    for motion in shown:
        for name, cuts in cuts_by_command(loop, motion).items():
            if cuts:
                spent, first = sum(cut.end - cut.begin for cut in cuts), cuts[0].begin
                found.append(
                    f"{name} for {significant(spent)} s from {significant(first)} s on "
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
