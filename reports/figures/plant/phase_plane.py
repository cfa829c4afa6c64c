"""Motions in planes of two states, with the box and the proved ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.reports.figures.style import COLOURS, GREY, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

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
