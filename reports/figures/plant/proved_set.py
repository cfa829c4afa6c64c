"""Planes of two states: the proved set, motions, box and ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.file_units import file_unit
from takagi.reports.figures.style import COLOURS, GREY, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

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


POINTS = 181
MOST_PLANES = 4
LEVELS = (0.25, 0.5, 0.75)


def planes(loop: PlantLoop) -> list[tuple[int, int]]:
    """Return the pairs of states that are drawn: neighbours, the first with the last if odd."""
    n = len(loop.names)
    if n < 2:
        return []
    pairs = [(k, k + 1) for k in range(0, n - 1, 2)]
    if n % 2:
        pairs.append((0, n - 1))
    return pairs[:MOST_PLANES]


def ellipse(P: Floats, level: float, pair: tuple[int, int], *, points: int = POINTS) -> Floats:
    """Return (2, points): the border of the projection of {x'Px <= level} onto two states.

    The projection is {y' S^-1 y <= level} with S the 2 x 2 block of P^-1.
    """
    block = np.linalg.inv(P)[np.ix_(pair, pair)]
    angle = np.linspace(0.0, 2 * np.pi, points)
    circle = np.stack((np.cos(angle), np.sin(angle)))
    return np.asarray(np.sqrt(level) * np.linalg.cholesky(block) @ circle, dtype=np.float64)


def phase_figure(loop: PlantLoop, motions: Sequence[PlantMotion]) -> Figure:
    """Return the motions in each plane; dots where they start, deviations from rest in SI."""
    pairs = planes(loop)
    across = min(len(pairs), 2)
    rows = -(-len(pairs) // across)
    with house_style():
        figure, panels = new_figure(rows, across, height=4.6 if rows * across == 1 else 3.6 * rows)
        for axes, pair in zip(panels, pairs, strict=False):
            _plane(axes, loop, motions, pair)
        for axes in panels[len(pairs) :]:
            axes.set_visible(False)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _plane(
    axes: Axes, loop: PlantLoop, motions: Sequence[PlantMotion], pair: tuple[int, int]
) -> None:
    i, j = pair
    for k, motion in enumerate(motions):
        x, y = motion.state[:, i], motion.state[:, j]
        axes.plot(
            x, y, color=COLOURS[0], lw=1.0,
            label="motion of the plant" if k == 0 else None,
        )  # fmt: skip
        axes.plot(x[:1], y[:1], "o", color=COLOURS[0], ms=3.5, label="start" if k == 0 else None)
    drawn = [m.state[:, [i, j]] for m in motions]
    if loop.bounded:
        P, level = loop.ellipsoid
        border = ellipse(P, level, pair)
        words = "ellipsoid in the box" if len(loop.names) == 2 else "its shadow"
        axes.plot(*border, color=COLOURS[1], lw=2.0, label=words)
        if len(loop.names) == 2:
            for share in LEVELS:
                axes.plot(*ellipse(P, share * level, pair), color=COLOURS[1], lw=0.6)
        drawn.append(border.T)
    _box(axes, loop, pair)
    axes.plot([0], [0], "+", color="black", ms=9, label="rest")
    size = np.abs(np.concatenate(drawn)).max(axis=0) * 1.15
    reach = [_side(loop, k) for k in pair]
    limits = [max(s, 1.08 * r) if r and r < 4 * s else s for s, r in zip(size, reach, strict=True)]
    axes.set_xlim(-limits[0], limits[0])
    axes.set_ylim(-limits[1], limits[1])
    axes.set_xlabel(loop.model.states[i])
    axes.set_ylabel(loop.model.states[j])


def _side(loop: PlantLoop, state: int) -> float:
    ends = loop.model.box.get(loop.model.states[state])
    return 0.0 if ends is None else max(abs(float(end)) for end in ends)


def _box(axes: Axes, loop: PlantLoop, pair: tuple[int, int]) -> None:
    """Draw the sides of the box that bound these states."""
    first = True
    for state, draw in zip(pair, (axes.axvline, axes.axhline), strict=True):
        for end in loop.model.box.get(loop.model.states[state]) or ():
            draw(float(end), color=GREY, lw=1.2, ls="--", label="box" if first else None)
            first = False
