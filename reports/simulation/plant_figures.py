"""A simulation of a plant over time, in the units of its file: states, inputs, disturbances, V."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.plant import Variable, file_unit
from takagi.reports.figures.loops import Panel, motions_figure
from takagi.reports.figures.plant.captioned import numbers_csv
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.figures.style import GREY, figure_to_svg
from takagi.reports.loops.plant_loop import PlantLoop
from takagi.reports.loops.plant_motion import PlantMotion
from takagi.reports.simulation.plant_words import PlantScenario, moving_disturbances

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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

    def finish(axes: Axes, k: int) -> None:
        if k == len(panels):
            axes.axhline(1.0, color=GREY, lw=0.9, ls="--")
            return
        _, series, ends, rest, command, _ = panels[k]
        if rest is not None:
            axes.axhline(rest, color=GREY, lw=0.7, ls=":")
        _limits(axes, series, ends)
        if command is not None:
            _cuts(axes, motions, command)

    shown = [Panel(label, series, held) for label, series, *_, held in panels]
    return motions_figure(motions, shown, finish, height=1.35, legend_columns=2)


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
    return numbers_csv(heads, np.concatenate(rows))


# Label, one series for each motion, ends of the range, rest, number of the command, held or not.
_Panel = tuple[str, list[Floats], tuple[float, float] | None, float | None, int | None, bool]


def _panels(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> list[_Panel]:
    held = loop.discrete or scenario.sample_time is not None

    def panel(
        variable: Variable,
        values: Sequence[Floats],
        *,
        rest: float | None = None,
        command: int | None = None,
    ) -> _Panel:
        side, (size, unit) = variable.range, file_unit(variable)
        ends = None if side is None else (float(side.lower) / size, float(side.upper) / size)
        shown_rest = None if rest is None else rest / size
        series = [each / size for each in values]
        steps = loop.discrete if command is None else held
        return f"{variable.name}\n[{unit}]", series, ends, shown_rest, command, steps

    commanded = [(v, [motion.input[:, k] for motion in motions])
                 for k, v in enumerate(loop.plant.inputs)]  # fmt: skip
    for k, actuator in enumerate(() if loop.blend is None else loop.blend.blending.actuators):
        commanded.append((actuator.variable, [motion.acting[:, k] for motion in motions]))
    return [
        *(
            panel(v, [rest + motion.state[:, k] for motion in motions], rest=rest)
            for k, (v, rest) in enumerate(zip(loop.plant.states, loop.state, strict=True))
        ),
        *(panel(v, values, command=k) for k, (v, values) in enumerate(commanded)),
        *(
            panel(v, [motion.disturbance[:, k] for motion in motions])
            for k, v in enumerate(moving_disturbances(scenario, loop.plant))
        ),
    ]


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
