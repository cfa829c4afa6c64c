"""Poles of vertices and plant with the proved decay rate; motions over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex
from takagi.reports.figures.style import COLOURS, GREY, STYLES, decimate, house_style, new_figure
from takagi.reports.loops.plant_local import pair_poles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

# Beyond this ratio of the fastest to the slowest pole both axes become logarithmic.
SPREAD = 30.0


def equilibrium_poles(loop: PlantLoop) -> tuple[Complex, Complex]:
    """Return the poles where the plant rests: without the law, and with it (empty if none)."""
    matrices, K = loop.at_rest()
    alone = np.linalg.eigvals(matrices.A).astype(np.complex128)
    if K is None:
        return alone, np.zeros(0, dtype=np.complex128)
    if loop.observed is not None:
        return alone, loop.observed.poles_at(loop.memberships(np.zeros(len(loop.names))))
    return alone, np.linalg.eigvals(matrices.A - matrices.B @ K).astype(np.complex128)


def vertex_poles_figure(loop: PlantLoop) -> Figure:
    """Return the poles of G_ii, of (G_ij + G_ji) / 2, and at rest, in the complex plane."""
    own, pairs = pair_poles(loop)
    alone, closed = equilibrium_poles(loop)
    with house_style():
        figure, (axes,) = new_figure(height=4.2)
        if pairs.size:
            axes.plot(
                pairs.real, pairs.imag, ".", color=GREY, ms=4, alpha=0.6,
                label="pairs of rules, (G$_{ij}$ + G$_{ji}$)/2", ls="none",
            )  # fmt: skip
        words = "vertices, A$_i$" if loop.gains is None else "vertices with own gains, G$_{ii}$"
        axes.plot(own.real, own.imag, "o", color=COLOURS[0], ms=5, label=words, ls="none")
        axes.plot(
            alone.real, alone.imag, "^", color=COLOURS[2], ms=7, mfc="none", mew=1.5,
            label="at rest without the law" if closed.size else "at rest", ls="none",
        )  # fmt: skip
        if closed.size:
            axes.plot(
                closed.real, closed.imag, "x", color=COLOURS[1], ms=8, mew=2,
                label="at rest with the law", ls="none",
            )  # fmt: skip
        (_unit_circle if loop.discrete else _half_plane)(axes, loop)
        if not loop.discrete:
            _scale(axes, np.concatenate([own, pairs, alone, closed]))
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _half_plane(axes: Axes, loop: PlantLoop) -> None:
    axes.axvline(0.0, color=GREY, lw=1.0)
    axes.set_xlabel("real part [1/s]")
    axes.set_ylabel("imaginary part [rad/s]")
    if loop.decay_rate:
        axes.axvline(
            -loop.decay_rate, color=COLOURS[1], ls="--", lw=1.2,
            label=f"proved decay rate, {loop.decay_rate:.3g} 1/s",
        )  # fmt: skip


def _unit_circle(axes: Axes, loop: PlantLoop) -> None:
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 241))
    axes.plot(turn.real, turn.imag, color=GREY, lw=1.0)
    if loop.decay_rate and loop.model.sample_time:
        rho = float(np.exp(-loop.decay_rate * loop.model.sample_time))
        axes.plot(
            rho * turn.real, rho * turn.imag, color=COLOURS[1], ls="--", lw=1.2,
            label=f"proved decay, radius {rho:.3g}",
        )  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("real part [-]")
    axes.set_ylabel("imaginary part [-]")


def _scale(axes: Axes, every: Complex) -> None:
    """Use symmetric logarithmic axes where a linear one would hide the slow poles."""
    size = np.abs(every)
    moving = size[size > 1e-9]
    if not moving.size or moving.max() < SPREAD * moving.min():
        return
    threshold = float(10 ** np.floor(np.log10(max(moving.min(), 1e-3 * moving.max()))))
    axes.set_xscale("symlog", linthresh=threshold)
    if np.abs(every.imag).max() > 10 * threshold:
        axes.set_yscale("symlog", linthresh=threshold)


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
    figure.align_ylabels(panels)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 3))
