"""Linear loops and simulated motions: poles, margins, responses, beside an LQ regulator's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.plant.plant import file_unit
from takagi.reports.figures.loops import equilibrium_poles
from takagi.reports.figures.plant.captioned import Drawn, captioned_bode_figures
from takagi.reports.loops.plant_local import (
    LISTED,
    PlantLocalLoop,
    Regulator,
    regulator,
    rest_loops,
)
from takagi.reports.loops.plant_loop import PlantLoop
from takagi.reports.loops.plant_motion import PlantMotion, settling_time
from takagi.reports.page.assembly import margin_table
from takagi.reports.page.text import Section, behind, complex_words, name_of, significant
from takagi.reports.sections.plant.summary import least_margins
from takagi.reports.simulation.plant_words import cuts_by_command

FOLDED = 8


def loops_section(design: PlantDesign, loop: PlantLoop, loops: Sequence[PlantLocalLoop]) -> Section:
    """Return the section with Bode plots and margins; only for a plant with a law."""
    beside = regulator(design)
    regulator_loops = () if beside is None else rest_loops(loop, beside.gain)
    table_rows = [
        ((local_loop.place, name_of(local_loop.input)), local_loop.margins) for local_loop in loops
    ]
    at = sum(local_loop.place == "rest" for local_loop in loops)
    table_rows[at:at] = [
        (("rest, LQR", name_of(local_loop.input)), local_loop.margins)
        for local_loop in regulator_loops
    ]
    return Section(
        "loops",
        "Margins and Bode plots",
        {
            "figures": list(captioned_bode_figures(loops)),
            "table": margin_table(table_rows, folded_from=FOLDED),
            "least": ", ".join(
                f"{number.quantity} {significant(number.value, 2)}{behind(number.unit)}"
                for number in least_margins(loops[:at]) or ()
            ),
            "compared": "" if beside is None else _beside_regulator(loop, beside, loops[:at]),
            "weights": [] if beside is None else _weights(loop, beside),
            "unstable": [
                f"{local_loop.place}, {name_of(local_loop.input)}"
                for local_loop in loops
                if not local_loop.margins.stable
            ],
            "left_out": 0 if len(loop.model.rules) <= LISTED else len(loop.model.rules),
            "vertices": len(loops) > at,
            "discrete": loop.discrete,
            "inputs": len(loop.model.inputs),
        },
    )


def _beside_regulator(loop: PlantLoop, beside: Regulator, loops: Sequence[PlantLocalLoop]) -> str:
    """Return where the law is better and where worse than the regulator, both linear at rest."""
    margins = least_margins(loops) or ()
    regulator_margins = least_margins(rest_loops(loop, beside.gain)) or ()
    theirs = {number.quantity: number for number in regulator_margins}
    pairs = [
        (f"{n.quantity} margin", n.value, theirs[n.quantity].value, n.unit, True)
        for n in margins
        if n.quantity in theirs
    ]
    times = [
        beside.settling(of_design=of_design, step=loop.model.sample_time)
        for of_design in (True, False)
    ]
    if times[0] is not None and times[1] is not None:
        pairs.append(("settling time", times[0], times[1], "s", False))
    return comparison("LQR", pairs)


def comparison(reference_law: str, pairs: Sequence[tuple[str, float, float, str, bool]]) -> str:
    """Return one sentence: where a law is worse than another, and where better.

    ``pairs`` : (quantity, of the law, of the other, unit, whether more is better).
    """
    sides: dict[str, list[str]] = {"worse": [], "better": []}
    for name, mine, theirs, unit, larger_is_better in pairs:
        first, second = significant(mine), significant(theirs)
        if first != second and not np.isnan(mine):
            words = f"{name} {first} against {second}{behind(unit)}"
            sides["better" if (mine > theirs) == larger_is_better else "worse"].append(words)
    clauses = [f"{side} in {', '.join(words)}" for side, words in sides.items() if words]
    return f"Beside {reference_law} this law is {'; it is '.join(clauses)}." if clauses else ""


def _weights(loop: PlantLoop, beside: Regulator) -> list[str]:
    sizes = [
        *zip(loop.plant.states, beside.states, strict=True),
        *zip(loop.plant.inputs, beside.inputs, strict=True),
    ]
    return [
        f"{v.name}: {significant(float(size) / file_unit(v)[0])}{behind(file_unit(v)[1])}"
        for v, size in sizes
    ]


# The tolerance of the integration may make V rise by this share of its first value.
SLACK = 1e-5
NOTHING = Drawn(())


def motion_section(
    loop: PlantLoop,
    simulated: Sequence[PlantMotion],
    drawn: Drawn,
    jumps: Sequence[PlantMotion] = (),
    jumped: Drawn = NOTHING,
    regulator_motions: Sequence[PlantMotion] = (),
) -> Section:
    """Return the section with responses over time.

    Parameters
    ----------
    jumps, jumped : motions after jumps of references, and their figures.
    regulator_motions : the motions from the same starts under a linear-quadratic regulator.
    """
    poles = (", ".join(complex_words(values)) for values in equilibrium_poles(loop))
    times = [settling_time(motion) for motion in simulated]
    return Section(
        "responses",
        "Motions of the nonlinear plant",
        {
            "figures": list(drawn.captioned_figures),
            "jumps": list(jumped.captioned_figures),
            "slowest": f"{significant(max(times))} s" if times and np.isfinite(times).all() else "",
            "poles": list(poles),
            "discrete": loop.discrete,
            "compared": _beside_motions(loop, simulated, regulator_motions),
            "lost": [motion.name for motion in (*simulated, *jumps) if not motion.whole],
            "rising": [
                motion.name
                for motion in simulated
                if np.any(np.diff(motion.value) > SLACK * motion.value[:1])
            ],
            "cut": cut_words(loop, [*simulated, *jumps]),
            "law": loop.gains is not None,
        },
    )


def _beside_motions(
    loop: PlantLoop, simulated: Sequence[PlantMotion], regulator_motions: Sequence[PlantMotion]
) -> str:
    """Return where the law is worse than the regulator from the same starts, and where better."""
    lost = [motion.name for motion in regulator_motions if np.isnan(settling_time(motion))]
    if lost:
        return f"Under LQR these starts do not settle in the time shown: {', '.join(lost)}."
    pairs = [
        (f"settling from {mine.name}", settling_time(mine), settling_time(theirs), "s", False)
        for mine, theirs in zip(simulated, regulator_motions, strict=False)
    ]
    for k, variable in enumerate(loop.plant.inputs if regulator_motions else ()):
        size, unit = file_unit(variable)
        mine, theirs = (
            max(float(np.abs(motion.input[:, k] - loop.input[k]).max()) / size for motion in runs)
            for runs in (simulated, regulator_motions)
        )
        pairs.append((f"largest |{variable.name}|", mine, theirs, unit, False))
    return comparison("LQR, from the same starts,", pairs)


def cut_words(loop: PlantLoop, simulated: Sequence[PlantMotion]) -> list[str]:
    """Return for each motion and input when its command was beyond the range, and for how long."""
    phrases = []
    for motion in simulated:
        for name, cuts in cuts_by_command(loop, motion).items():
            if cuts:
                spent, first = sum(cut.end - cut.begin for cut in cuts), cuts[0].begin
                phrases.append(
                    f"{name} for {significant(spent)} s from {significant(first)} s on "
                    f"({motion.name})"
                )
    return phrases
