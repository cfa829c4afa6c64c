"""Planes of two states: the proved set, motions and the box."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.plant import file_unit
from takagi.reports.figures.style import COLOURS, GREY, WIDTH, house_style, new_figure
from takagi.reports.loops.plant_loop import PlantLoop, PolynomialRegion
from takagi.reports.loops.plant_motion import PlantMotion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_STATES = 6
BESIDE = 1.15  # of the set's half-width: how far an axis reaches without a box near by
FILLED = "#CFE3F1"  # the first colour, pale
MOTION = "#333333"
NEAR = 4.0  # a side of the box this many times as far is not drawn


def pairs(loop: PlantLoop) -> list[tuple[int, int]]:
    """Return every pair of the first six states; none without a proved set."""
    if not (loop.bounded and loop.level_proved):
        return []
    return list(combinations(range(min(len(loop.names), MOST_STATES)), 2))


def set_figure(loop: PlantLoop) -> Figure:
    """Return one panel a pair: starts with the others at rest, projection of the set, and the box.

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
            _panel(axes, loop, (i, j))
            axes.label_outer()
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def section(P: Floats, level: float, pair: tuple[int, int]) -> Floats:
    """Return (2, points): the border of {x'Px <= level} where all other states are at rest."""
    block = P[np.ix_(pair, pair)]
    return ellipse(block, level, (0, 1))


def _panel(
    axes: Axes, loop: PlantLoop, pair: tuple[int, int], motions: Sequence[PlantMotion] = ()
) -> None:
    """Draw the set, the box and motions as deviations from rest, in the units of the file."""
    units = [file_unit(loop.plant.states[k]) for k in pair]
    sizes = np.array([[size] for size, _ in units])
    drawn = [motion.state[:, pair].T / sizes for motion in motions]
    for k, (x, y) in enumerate(drawn):
        named = "motion, simulated" if k == 0 else None
        axes.plot(x, y, color=MOTION, lw=0.9, label=named, marker="o", ms=3.5, markevery=[0])
    if loop.bounded:
        drawn.append(_set(axes, loop, pair, sizes))
    if loop.region is not None:
        drawn.append(_polynomial_set(axes, loop.region, len(loop.names), pair, sizes))
    reach = np.max([np.abs(points).max(axis=1) for points in drawn], axis=0)
    limits = []
    for k, (state, draw) in enumerate(zip(pair, (axes.axvline, axes.axhline), strict=True)):
        sides = loop.model.box.get(loop.model.states[state], ())
        ends = [float(end) / units[k][0] for end in sides]
        near = [end for end in ends if abs(end) < NEAR * reach[k]]
        for end in near:
            label = "range in the file" if k == 0 and end == near[0] else None
            draw(end, color=GREY, lw=1.0, ls=":", label=label)
        limits.append(max([BESIDE * reach[k], *(1.08 * abs(end) for end in near)]))
    axes.set_xlim(-limits[0], limits[0])
    axes.set_ylim(-limits[1], limits[1])
    axes.plot([0], [0], "+", color="black", ms=8, ls="none", label="rest")
    words = [f"{loop.names[k]} [{unit}]" for k, (_, unit) in zip(pair, units, strict=True)]
    axes.set_xlabel(words[0])
    axes.set_ylabel(words[1])


def _set(axes: Axes, loop: PlantLoop, pair: tuple[int, int], sizes: Floats) -> Floats:
    """Draw where motions may start and what they never leave; return the border of that."""
    P, level = loop.ellipsoid
    starting, _ = loop.start_ellipsoid
    projection, inner = ellipse(P, level, pair) / sizes, section(starting, level, pair) / sizes
    # Of two states every start is drawn; with an observer a motion may leave the starts.
    whole = len(loop.names) == 2 and loop.observed is None
    words = "safe starts" if whole else "safe starts, other states at rest"
    if not loop.level_proved:
        words = "ellipsoid in the ranges, not proved"
    axes.fill(*inner, facecolor=FILLED, edgecolor=COLOURS[0], lw=1.6, label=words, zorder=1.5)
    if not whole:
        words = "projection of the set, never left" if loop.level_proved else "its projection"
        axes.plot(*projection, color=COLOURS[1], lw=1.6, ls="--", label=words)
    return projection


def _polynomial_set(
    axes: Axes, region: PolynomialRegion, n: int, pair: tuple[int, int], sizes: Floats
) -> Floats:
    """Draw {V <= level} where the other states are at rest; return its border."""
    reach = np.array([region.starts[k] for k in pair])
    angle = np.linspace(0.0, 2 * np.pi, POINTS)
    directions = np.zeros((POINTS, n))
    directions[:, pair] = np.stack((np.cos(angle), np.sin(angle)), axis=1) * reach
    distances = np.linspace(0.0, FARTHEST, RAYS)[1:, None, None]
    outside = region.V(distances * directions) > region.level
    first = np.where(outside.any(axis=0), outside.argmax(axis=0), RAYS - 2)
    ends = [distances[np.maximum(first - 1, 0), 0], distances[first, 0]]
    for _ in range(HALVINGS):
        middle = (ends[0] + ends[1]) / 2
        beyond = (region.V(middle * directions) > region.level)[:, None]
        ends = [np.where(beyond, ends[0], middle), np.where(beyond, middle, ends[1])]
    border = (ends[0] * directions)[:, pair].T / sizes
    axes.plot(*border, color=COLOURS[2], lw=1.6, label="safe starts by a polynomial")
    return np.asarray(border)


# How far a border is looked for, over its distance along the axes; steps, and their halvings.
FARTHEST, RAYS, HALVINGS = 6.0, 301, 20
POINTS = 181
MOST_PLANES = 4


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


def phase_figure(
    loop: PlantLoop, motions: Sequence[PlantMotion], *, most: int = MOST_PLANES
) -> Figure:
    """Return motions, set and box in at most so many planes, in the units of the file."""
    shown = planes(loop)[:most]
    across = min(len(shown), 2)
    rows = -(-len(shown) // across)
    # The legend of one plane is as wide as this.
    width, height = (WIDTH, 0.6 + 3.2 * rows) if across > 1 else (5.2, 3.4)
    with house_style():
        figure, panels = new_figure(rows, across, width=width, height=height)
        for axes, pair in zip(panels, shown, strict=False):
            _panel(axes, loop, pair, motions)
        for axes in panels[len(shown) :]:
            axes.set_visible(False)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure
