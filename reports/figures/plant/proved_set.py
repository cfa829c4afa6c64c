"""The proved set in the plane of every pair of states, in the units of the plant's file."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.file_units import file_unit
from takagi.reports.figures.plant.phase_plane import ellipse
from takagi.reports.figures.style import COLOURS, GREY, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop

MOST_STATES = 6
BESIDE = 1.15  # of the set's half-width: how far an axis reaches without a box near by
FILLED = "#CFE3F1"  # the first colour, pale
NEAR = 4.0  # a side of the box this many times as far is not drawn


def pairs(loop: PlantLoop) -> list[tuple[int, int]]:
    """Return every pair of the first six states; none without a proved set."""
    if not (loop.bounded and loop.level_proved):
        return []
    return list(combinations(range(min(len(loop.names), MOST_STATES)), 2))


def set_figure(loop: PlantLoop) -> Figure:
    """Return one panel a pair: starts with the others at rest, shadow of the set, and the box.

    The panel of states i < j stands in column i and row j, so that states share their axes.
    """
    drawn = pairs(loop)
    last = max(j for _, j in drawn)
    size = min(7.0, 3.6 + 1.1 * last)
    with house_style():
        figure, panels = new_figure(last, last, width=size, height=0.86 * size + 0.5)
        for axes in panels:
            axes.set_visible(False)
        for i, j in drawn:
            axes = panels[(j - 1) * last + i]
            axes.set_visible(True)
            _panel(axes, loop, (i, j), left=i == 0, bottom=j == last)
        figure.align_labels()
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def section(P: Floats, level: float, pair: tuple[int, int]) -> Floats:
    """Return (2, points): the border of {x'Px <= level} where all other states are at rest."""
    block = P[np.ix_(pair, pair)]
    return ellipse(block, level, (0, 1))


def _panel(axes: Axes, loop: PlantLoop, pair: tuple[int, int], *, left: bool, bottom: bool) -> None:
    P, level = loop.ellipsoid
    units = [file_unit(loop.plant.states[k]) for k in pair]
    sizes = np.array([[size] for size, _ in units])
    starting, _ = loop.start_ellipsoid
    shadow, inner = ellipse(P, level, pair) / sizes, section(starting, level, pair) / sizes
    # Of two states every start is drawn; with an observer a motion may leave the starts.
    whole = len(loop.names) == 2 and loop.observed is None
    words = "starts in the set" if whole else "starts, others at rest"
    axes.fill(*inner, facecolor=FILLED, edgecolor=COLOURS[0], lw=1.2, label=words)
    if not whole:
        words = "shadow of the set: all motions"
        axes.plot(*shadow, color=COLOURS[1], lw=1.6, ls="--", label=words)
    reach = np.abs(shadow).max(axis=1)
    ranges = []
    for k, (state, draw) in enumerate(zip(pair, (axes.axvline, axes.axhline), strict=True)):
        sides = loop.model.box.get(loop.model.states[state], ())
        ends = [float(end) / units[k][0] for end in sides]
        near = [end for end in ends if abs(end) < NEAR * reach[k]]
        for end in near:
            draw(end, color=GREY, lw=1.0, ls=":", label="box" if k == 0 and end < 0 else None)
        far = max([BESIDE * reach[k], *(1.08 * abs(end) for end in near)])
        ranges.append((-far, far))
    axes.set_xlim(*ranges[0])
    axes.set_ylim(*ranges[1])
    axes.plot([0], [0], "+", color="black", ms=7, label="rest")
    for shown, k, name in ((bottom, 0, axes.set_xlabel), (left, 1, axes.set_ylabel)):
        if shown:
            label = loop.names[pair[k]]
            name(f"{label} [{units[k][1]}]")
    axes.tick_params(labelbottom=bottom, labelleft=left)
