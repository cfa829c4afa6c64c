"""The figures of a plant's design with captions, and their data as CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.blending.blending import RunTimeBlending
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise
from takagi.reports.figures.loops import (
    Panel,
    bode_figure,
    bode_line,
    motions_figure,
    responses_figure,
)
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.figures.style import (
    COLOURS,
    SEQUENTIAL,
    STYLES,
    captioned_figure,
    house_style,
    new_figure,
)
from takagi.reports.loops.plant_local import PlantLocalLoop, common_frequencies
from takagi.reports.loops.plant_loop import PlantLoop
from takagi.reports.loops.plant_motion import PlantMotion, around, motions
from takagi.reports.output import csv_text
from takagi.reports.page.text import CaptionedFigure, behind, name_of, powers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LINE, GRID = 201, 61
TRIES, SEED = 6, 5


class PremiseCurve(NamedTuple):
    """A premise along the one or two variables that it depends on, all others at rest.

    Attributes
    ----------
    variables : labels with units, one or two; further ones it depends on are in ``held``.
    axes : a grid of each variable, in deviations from rest.
    value : (k,) or (k2, k1), the last axis that of the first variable.
    """

    premise: Premise
    variables: tuple[str, ...]
    axes: tuple[Floats, ...]
    value: Floats
    held: tuple[str, ...] = ()


def premise_curves(model: TSModel) -> tuple[PremiseCurve, ...]:
    """Return a curve (or surface) for each premise that is not constant."""
    rest = {name_of(label): 0.0 for label in (*model.states, *model.inputs, *model.disturbances)}
    return tuple(
        _curve(model, premise, rest)
        for premise in model.premises
        if len(premise.corners) > 1 and premise.evaluate is not None
    )


def weights_figure(curves: tuple[PremiseCurve, ...]) -> Figure:
    """Return one panel per premise: w_0 and w_1 over its variable, or w_1 over two."""
    across = 1 if len(curves) == 1 else 2
    rows = -(-len(curves) // across)
    with house_style():
        figure, panels = new_figure(rows, across, height=3.0 if rows == 1 else 2.6 * rows)
        for axes, curve in zip(panels, curves, strict=False):
            draw = _line if len(curve.variables) == 1 else _surface
            draw(axes, curve)
            premise = curve.premise
            ends = f"[{float(premise.lower):.5g}, {float(premise.upper):.5g}]"
            unit = behind(powers(premise.unit))
            axes.set_title(f"{premise.name} in {ends}{unit}", fontsize=9.5)
        for axes in panels[len(curves) :]:
            axes.set_visible(False)
        lines = next((a for a, c in zip(panels, curves, strict=False) if len(c.axes) == 1), None)
        if lines is not None:
            figure.legend(*lines.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _curve(model: TSModel, premise: Premise, rest: dict[str, float]) -> PremiseCurve:
    assert premise.evaluate is not None
    box = {label: (float(a), float(b)) for label, (a, b) in model.box.items()}
    ranges = {label: box[label] for label in box if name_of(label) in rest}
    variables = _dependent(premise, ranges, rest) or list(ranges)[:1]
    drawn = tuple(variables[:2])
    size = LINE if len(drawn) == 1 else GRID
    axes = tuple(np.linspace(*ranges[label], size) for label in drawn)

    def value(*point: float) -> float:
        assert premise.evaluate is not None
        names = [name_of(label) for label in drawn]
        return premise.evaluate(**{**rest, **dict(zip(names, point, strict=True))})

    if len(drawn) == 1:
        values = np.array([value(float(x)) for x in axes[0]])
    else:
        values = np.array([[value(float(x), float(y)) for x in axes[0]] for y in axes[1]])
    return PremiseCurve(premise, drawn, axes, values, tuple(variables[2:]))


def _dependent(
    premise: Premise, box: dict[str, tuple[float, float]], rest: dict[str, float]
) -> list[str]:
    """Return the variables whose change alone moves the premise somewhere in the box."""
    assert premise.evaluate is not None
    chance = np.random.default_rng(SEED)
    variables = []
    for label in box:
        name = name_of(label)
        for _ in range(TRIES):
            point = {**rest, **{name_of(k): chance.uniform(*ends) for k, ends in box.items()}}
            first = premise.evaluate(**point)
            if premise.evaluate(**{**point, name: chance.uniform(*box[label])}) != first:
                variables.append(label)
                break
    return variables


def _line(axes: Axes, curve: PremiseCurve) -> None:
    weights = curve.premise.weights(curve.value, clip=True)
    for weight, words, colour, style in zip(
        weights, ("weight of the lower bound", "weight of the upper bound"), COLOURS, STYLES,
        strict=False,
    ):  # fmt: skip
        axes.plot(curve.axes[0], weight, color=colour, linestyle=style, label=words)
    axes.set_xlim(curve.axes[0][0], curve.axes[0][-1])
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(powers(curve.variables[0]))
    axes.set_ylabel("weight [-]")


def _surface(axes: Axes, curve: PremiseCurve) -> None:
    upper = curve.premise.weights(curve.value, clip=True)[1]
    levels = np.linspace(0.0, 1.0, 11)
    filled = axes.contourf(*curve.axes, upper, levels=levels, cmap=SEQUENTIAL)
    bar = axes.figure.colorbar(filled, ax=axes, ticks=[0.0, 0.5, 1.0])
    bar.set_label("weight of the\nupper bound [-]")
    axes.set_xlabel(powers(curve.variables[0]))
    axes.set_ylabel(powers(curve.variables[1]))


SHADE = "#eeeeee"


def hand_over_figure(
    blend: RunTimeBlending, motions: Sequence[PlantMotion], effort_rest: float
) -> Figure:
    """Return the effort and both actuators over time, a line for each motion."""
    blending, e = blend.blending, float(blend.blending.overlap)
    efforts = [motion.state[:, -1] + effort_rest for motion in motions]
    panels = [Panel(f"effort\n[{blending.effort.unit}]", efforts)]
    for k, actuator in enumerate(blending.actuators):
        label = f"{actuator.name}\n[{actuator.variable.unit}]"
        panels.append(Panel(label, [motion.acting[:, k] for motion in motions]))

    def shade(axes: Axes, k: int) -> None:
        if k == 0:
            axes.axhspan(-e, e, color=SHADE, zorder=0)

    without_value = [replace(motion, value=np.zeros(0)) for motion in motions]
    return motions_figure(without_value, panels, shade, height=5 / 3)


# Starts around the set of two states, and of more.
AROUND, AROUND_MANY = 12, 4
MOST_LINES = 6


class Drawn(NamedTuple):
    """Figures with captions, and file name -> CSV of the numbers that they show."""

    captioned_figures: tuple[CaptionedFigure, ...]
    data: Mapping[str, str] = MappingProxyType({})


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
