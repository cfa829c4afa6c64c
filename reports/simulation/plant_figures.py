"""A simulation of a plant over time, in the units of its file: states, inputs, disturbances, V."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.plant import file_unit
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    STYLES,
    decimate,
    figure_to_svg,
    house_style,
    new_figure,
)
from takagi.reports.output import csv_text
from takagi.reports.simulation.plant_words import PlantScenario, moving_disturbances

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.models.plant.plant import Variable
    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

MOST_PANELS = 12
_SHADE = "#f3d9c8"


def simulated_figures(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> dict[str, str]:
    """Return name -> SVG: the responses over time and, for two states or more, planes of states."""
    about = f"{loop.plant.name}, simulated"
    found = {
        "responses": figure_to_svg(
            simulated_responses(loop, motions, scenario),
            name="figure-responses",
            description=f"{about}: states, inputs and disturbances over time",
        )
    }
    if planes(loop):
        found["phase"] = figure_to_svg(
            phase_figure(loop, motions),
            name="figure-phase",
            description=f"{about}: motions in planes of two states",
        )
    return {name: f"{svg}\n" for name, svg in found.items()}


def simulated_responses(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> Figure:
    """Return one panel per state, input, actuator and disturbance that moves, and one for V.

    Values themselves, not deviations, in the units of the plant's file.  Dotted: where a state
    rests.  Dashed: ends of a range.  Shaded: where a command was cut in any of the runs.
    """
    panels = _panels(loop, motions, scenario)[:MOST_PANELS]
    valued = bool(motions[0].value.size)
    shown = list(zip(motions, COLOURS, STYLES, strict=False))
    rows = len(panels) + valued
    with house_style():
        figure, axes = new_figure(rows, 1, height=1.35 * rows + 1.0, share_x=True)
        for one, (label, series, ends, rest, command, steps) in zip(axes, panels, strict=False):
            for (motion, colour, style), values in zip(shown, series, strict=False):
                stepped = "steps-post" if steps else "default"
                one.plot(
                    *decimate(motion.time, values), color=colour, linestyle=style,
                    label=motion.name, drawstyle=stepped,
                )  # fmt: skip
            if rest is not None:
                one.axhline(rest, color=GREY, lw=0.7, ls=":")
            _limits(one, series, ends)
            if command is not None:
                _cuts(one, motions, command)
            one.set_ylabel(label)
        if valued:
            for motion, colour, style in shown:
                keep = motion.value > 1e-9
                axes[-1].semilogy(
                    motion.time[keep], motion.value[keep], color=colour, linestyle=style
                )
            axes[-1].axhline(1.0, color=GREY, lw=0.9, ls="--")
            axes[-1].set_ylabel("V / level\n[-]")
        axes[-1].set_xlim(0.0, max(float(motion.time[-1]) for motion in motions))
        axes[-1].set_xlabel("time [s]")
        handles, names = axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 2))
    return figure


def simulated_csv(loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario) -> str:
    """Return the numbers that the figure shows; at a jump there are two rows with one time.

    States and inputs themselves in the units of the file; ``wanted`` is a command before the cut.
    """
    parts = _panels(loop, motions, scenario)
    n, m = len(loop.names), len(loop.plant.inputs)
    wanted = [f"{v.name} wanted [{file_unit(v)[1]}]" for v in loop.plant.inputs if v.range]
    heads = ["run [-]", "time [s]", *(label.replace("\n", " ") for label, *_ in parts)]
    heads[2 + n + m : 2 + n + m] = wanted
    valued = bool(motions[0].value.size)
    rows: list[Floats] = []
    for k, motion in enumerate(motions):
        columns = [np.full(len(motion.time), k + 1), motion.time]
        columns += [series[k] for _, series, *_ in parts]
        columns[2 + n + m : 2 + n + m] = [
            motion.wanted[:, j] / file_unit(v)[0]
            for j, v in enumerate(loop.plant.inputs)
            if v.range
        ]
        columns += [motion.value] if valued else []
        rows.append(np.column_stack(columns))
    heads += ["V/level [-]"] * valued
    return csv_text(heads, ([f"{value:.8g}" for value in row] for row in np.concatenate(rows)))


# Label, one series for each motion, ends of the range, rest, number of the command, held or not.
_Panel = tuple[str, list[Floats], tuple[float, float] | None, float | None, int | None, bool]


def _panels(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> list[_Panel]:
    held = loop.discrete or scenario.sample_time is not None
    found: list[_Panel] = []
    for k, (variable, rest) in enumerate(zip(loop.plant.states, loop.state, strict=True)):
        size, _ = file_unit(variable)
        series = [(rest + motion.state[:, k]) / size for motion in motions]
        ends = _ends(variable)
        found.append((_label(variable), series, ends, rest / size, None, loop.discrete))
    for k, variable in enumerate(loop.plant.inputs):
        series = [motion.input[:, k] / file_unit(variable)[0] for motion in motions]
        found.append((_label(variable), series, _ends(variable), None, k, held))
    blended = () if loop.blend is None else loop.blend.blending.actuators
    for k, actuator in enumerate(blended):
        variable = actuator.variable
        series = [motion.acting[:, k] / file_unit(variable)[0] for motion in motions]
        place = len(loop.plant.inputs) + k
        found.append((_label(variable), series, _ends(variable), None, place, held))
    for k, variable in enumerate(moving_disturbances(scenario, loop.plant)):
        series = [motion.disturbance[:, k] / file_unit(variable)[0] for motion in motions]
        found.append((_label(variable), series, _ends(variable), None, None, loop.discrete))
    return found


def _label(variable: Variable) -> str:
    return f"{variable.name}\n[{file_unit(variable)[1]}]"


def _ends(variable: Variable) -> tuple[float, float] | None:
    side, (size, _) = variable.range, file_unit(variable)
    return None if side is None else (float(side.lower) / size, float(side.upper) / size)


def _limits(axes: Axes, series: Sequence[Floats], ends: tuple[float, float] | None) -> None:
    """Draw the ends of a range that are close to the series; others would flatten the curves."""
    if ends is None:
        return
    values = np.concatenate([one[np.isfinite(one)] for one in series])
    if not values.size:
        return
    low, high = float(values.min()), float(values.max())
    near = 0.6 * (high - low)
    for end in ends:
        if low - near <= end <= high + near:
            axes.axhline(end, color=GREY, lw=0.9, ls="--")


def _cuts(axes: Axes, motions: Sequence[PlantMotion], command: int) -> None:
    for motion in motions:
        for cut in motion.cuts:
            if cut.command == command:
                axes.axvspan(cut.begin, cut.end, color=_SHADE, lw=0, zorder=0)
