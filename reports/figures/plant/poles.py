"""Poles of the plant where it rests; motions over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex
from takagi.reports.figures.style import COLOURS, GREY, STYLES, decimate, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion


def equilibrium_poles(loop: PlantLoop) -> tuple[Complex, Complex]:
    """Return the poles where the plant rests: without the law, and with it (empty if none)."""
    matrices, K = loop.at_rest()
    alone = np.linalg.eigvals(matrices.A).astype(np.complex128)
    if K is None:
        return alone, np.zeros(0, dtype=np.complex128)
    if loop.observed is not None:
        return alone, loop.observed.poles_at(loop.memberships(np.zeros(len(loop.names))))
    return alone, np.linalg.eigvals(matrices.A - matrices.B @ K).astype(np.complex128)


MOST_PANELS = 10


def responses_figure(loop: PlantLoop, motions: Sequence[PlantMotion]) -> Figure:
    """Return one panel per state (deviation), per input, and one for V over its level."""
    lines = list(zip(motions, COLOURS, STYLES, strict=False))
    labels = [*loop.model.states, *(f"{v.name} [{v.unit}]" for v in loop.plant.inputs)]
    if loop.gains is None:
        labels = labels[: len(loop.names)]
    shown = labels[:MOST_PANELS]
    valued = bool(motions[0].value.size)
    rows = len(shown) + valued
    with house_style():
        figure, panels = new_figure(rows, 1, height=1.25 * rows + 1.0, share_x=True)
        for k, (axes, label) in enumerate(zip(panels, shown, strict=False)):
            for motion, colour, style in lines:
                series = np.column_stack((motion.state, motion.input))[:, k]
                axes.plot(
                    *decimate(motion.time, series),
                    color=colour, linestyle=style, label=motion.name,
                    drawstyle="steps-post" if loop.discrete else "default",
                )  # fmt: skip
            axes.axhline(0.0, color=GREY, lw=0.7)
            axes.set_ylabel(label.replace(" [", "\n["))
        if valued:
            for motion, colour, style in lines:
                keep = motion.value > 1e-9
                panels[-1].semilogy(
                    motion.time[keep], motion.value[keep], color=colour, linestyle=style
                )
            panels[-1].set_ylabel("V / level\n[-]")
        finish_over_time(figure, panels, motions)
    return figure


def finish_over_time(
    figure: Figure, panels: Sequence[Axes], motions: Sequence[PlantMotion]
) -> None:
    """Give panels of motions one axis of time and one legend."""
    panels[-1].set_xlim(0.0, max(float(motion.time[-1]) for motion in motions))
    panels[-1].set_xlabel("time [s]")
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 3))
