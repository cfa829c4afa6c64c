"""The figures of a plant's design with captions, and their data as CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.figures.loops import bode_figure, bode_line, responses_figure
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.figures.plant.weights import PremiseCurve, premise_curves, weights_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.plant_local import PlantLocalLoop, common_frequencies
from takagi.reports.loops.plant_motion import PlantMotion, around, motions
from takagi.reports.output import csv_text
from takagi.reports.page.text import CaptionedFigure, name_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop

# Starts around the set of two states, and of more.
AROUND, AROUND_MANY = 12, 4
MOST_LINES = 6


@dataclass(frozen=True, slots=True)
class Drawn:
    """Figures with captions, and file name -> CSV of the numbers that they show."""

    captioned_figures: tuple[CaptionedFigure, ...]
    data: Mapping[str, str] = field(default_factory=dict)


def captioned_weights_figure(loop: PlantLoop) -> Drawn:
    """Return how the premises' weights vary over the box; nothing if none varies."""
    curves = premise_curves(loop.model)
    if not curves:
        return Drawn(())
    held = sorted({name_of(label) for curve in curves for label in curve.held})
    captioned = captioned_figure(
        weights_figure(curves),
        "memberships",
        "weights",
        held=f" At rest: {', '.join(held)}." if held else "",
        names=", ".join(curve.premise.name for curve in curves),
    )
    return Drawn((captioned,), {f"memberships-{c.premise.name}.csv": _curve_csv(c) for c in curves})


def bode_drawings(loops: Sequence[PlantLocalLoop]) -> list[tuple[str, Figure]]:
    """Return (input, figure): at rest, and the vertices with the least disk margins."""
    if not loops:
        return []
    omega = common_frequencies(loops)
    drawings = []
    for name in dict.fromkeys(loop.input for loop in loops):
        of_input = [loop for loop in loops if loop.input == name]
        rest = [loop for loop in of_input if loop.place == "rest"]
        others = sorted(
            (loop for loop in of_input if loop not in rest),
            key=lambda loop: loop.margins.disk.alpha,
        )
        drawn = [*rest, *others[: MOST_LINES - 1]]
        lines = [bode_line(loop.place, loop.response, loop.margins, omega) for loop in drawn]
        drawings.append((name, bode_figure(omega, lines)))
    return drawings


def captioned_bode_figures(loops: Sequence[PlantLocalLoop]) -> tuple[CaptionedFigure, ...]:
    """Return one Bode plot per input."""
    return tuple(
        captioned_figure(
            figure, f"bode-{k}" if k > 1 else "bode", "plant-bode", at=name_of(name), input=name
        )
        for k, (name, figure) in enumerate(bode_drawings(loops), 1)
    )


def captioned_jumps_figure(loop: PlantLoop, runs: Sequence[PlantMotion]) -> Drawn:
    """Return responses over time after jumps of references; nothing without any."""
    if not runs:
        return Drawn(())
    followed = " and ".join(one.follows for one in loop.plant.references)
    # V is a function of deviations from the old rest.
    shown = [replace(run, value=np.zeros(0)) for run in runs]
    captioned = captioned_figure(responses_figure(loop, shown), "jumps", followed=followed)
    return Drawn((captioned,), {"jumps.csv": _motions_csv(loop, shown)})


def captioned_picture(loop: PlantLoop) -> Drawn:
    """Return the plane of the first two states: set, motions and box; nothing for one state."""
    if not planes(loop):
        return Drawn(())
    drawn = motions(loop, around(loop, AROUND if len(loop.names) == 2 else AROUND_MANY))
    words = ""
    if loop.bounded and (len(loop.names) > 2 or loop.observed is not None):
        words = ". Filled: section where all other states are at rest. Dashed: the whole set, "
        words += f"projected{'; no motion from it leaves it' if loop.level_proved else ''}"
    captioned = captioned_figure(phase_figure(loop, drawn, most=1), "phase", set=words)
    return Drawn((captioned,), {"phase.csv": _motions_csv(loop, drawn)})


def captioned_motion_figures(loop: PlantLoop, shown: Sequence[PlantMotion]) -> Drawn:
    """Return responses over time."""
    where = (
        "Starts lie just inside the set, each where one state is largest."
        if shown and shown[0].value.size
        else "No set is proved: starts at a share of the ranges, one state at a time."
    )
    captioned = captioned_figure(
        responses_figure(loop, shown), "responses", "motions", starts=where
    )
    return Drawn((captioned,), {"responses.csv": _motions_csv(loop, shown)})


def _curve_csv(curve: PremiseCurve) -> str:
    unit = curve.premise.unit
    head = [*curve.variables, f"{curve.premise.name} [{unit}]", "w0 [-]", "w1 [-]"]
    grids = np.meshgrid(*curve.axes)
    w0, w1 = curve.premise.weights(curve.value, clip=True)
    return numbers_csv(
        head, np.column_stack([part.ravel() for part in (*grids, curve.value, w0, w1)])
    )


def _motions_csv(loop: PlantLoop, shown: Sequence[PlantMotion]) -> str:
    inputs = [f"{v.name} [{v.unit}]" for v in loop.plant.inputs] if shown[0].input.size else []
    valued = bool(shown[0].value.size)
    blend = loop.blend
    blended = [] if blend is None else [a.variable.label for a in blend.blending.actuators]
    head = ["run [-]", "time [s]", *loop.model.states, *inputs, *blended]
    head += ["V/level [-]"] * valued
    blocks = []
    for number, motion in enumerate(shown, 1):
        parts = [np.full(len(motion.time), number), motion.time, motion.state]
        parts += [motion.input] if inputs else []
        parts += [motion.acting] if blended else []
        parts += [motion.value] if valued else []
        blocks.append(np.column_stack(parts))
    return numbers_csv(head, np.concatenate(blocks))


def numbers_csv(head: Sequence[str], rows: np.ndarray) -> str:
    """Return a table with a line of headings, numbers to eight digits."""
    return csv_text(head, ([f"{value:.8g}" for value in row] for row in rows))
