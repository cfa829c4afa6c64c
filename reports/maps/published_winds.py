"""Slices of the published law's map over wind: one mark a window, for a few torque overlaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.sweep.grid import PointResult, SweepResult
from takagi.models.laws.law_words import law_words
from takagi.reports.figures.style import COLOURS, SEQUENTIAL, house_style, new_figure, wind_axis
from takagi.reports.maps.published_rows import SPEED, TORQUE, windows_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

# Marks of a window that is proved: at the trim, and where the law rests elsewhere.
AT_TRIM, ELSEWHERE = "s", "o"
FAILED = COLOURS[1]
MOST_SLICES = 3


def wind_slices_figure(result: SweepResult) -> Figure:
    """Return marks over wind [m/s] and speed overlap [rad/s], coloured by proved decay rate [1/s].

    The strip at the top is the law that is compared with.  Slices: the smallest, a middle and the
    largest torque overlap.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    axis = next(axis for axis in result.map.axes if axis.name == TORQUE)
    count = len(axis.values)
    chosen = sorted({axis.values[k] for k in (0, (count - 1) // 2, count - 1)})[:MOST_SLICES]
    others = [point for other in result.beside for point in other.points]
    rates = _rates([*result.points, *others])
    norm = LogNorm(min(rates) / 1.01, max(rates) * 1.01) if rates else LogNorm(1e-3, 1e-1)
    colours = ScalarMappable(norm, SEQUENTIAL)
    speeds = len({point.at[SPEED] for point in result.points})
    tall = min(2.4, 0.5 + 0.16 * speeds)
    strips = len(others)
    heights = [0.3] * strips + [tall] * len(chosen)
    with house_style():
        figure, panels = new_figure(
            len(heights),
            1,
            width=8.0,
            height=sum(heights) + 0.45 * len(heights) + 1.0,
            share_x=True,
            height_ratios=heights,
        )
        for axes, other in zip(panels, result.beside, strict=False):
            _marks(axes, [(0.0, w) for w in windows_of(other.points[0])], colours)
            axes.set_yticks([])
            axes.set_title(
                f"{law_words(other.map.name)}, with gains found in two steps", loc="left"
            )
        for axes, torque in zip(panels[strips:], chosen, strict=True):
            points = [point for point in result.points if point.at[TORQUE] == torque]
            _marks(axes, [(p.at[SPEED], w) for p in points for w in windows_of(p)], colours)
            axes.set_ylabel("\u03b5$_\u03c9$ [rad/s]")
            axes.set_title(
                f"{law_words(result.map.name)}, torque overlap {torque / 1e3:.3g} kN m", loc="left"
            )
        wind_axis(panels[-1])
        figure.colorbar(colours, ax=panels, label="proved decay rate [1/s]", pad=0.01, aspect=40)
        _legend(figure)
    return figure


def _rates(points: Sequence[PointResult]) -> list[float]:
    found = [window["decay_rate [1/s]"] for point in points for window in windows_of(point)]
    return [rate for rate in found if rate is not None]


def _marks(
    axes: Axes, windows: Sequence[tuple[float, Mapping[str, Any]]], colours: ScalarMappable
) -> None:
    axes.grid(visible=False)
    for mark, kinds in ((AT_TRIM, ("intended",)), (ELSEWHERE, ("shifted", "continuum", "none"))):
        proved = [
            (w["wind [m/s]"][0], y, w["decay_rate [1/s]"])
            for y, w in windows
            if w["decay_rate [1/s]"] is not None and w["rest"] in kinds
        ]
        if proved:
            x, height, rate = np.array(proved).T
            axes.scatter(x, height, s=20, c=colours.to_rgba(rate), marker=mark)
    failed = [(w["wind [m/s]"][0], y) for y, w in windows if w["decay_rate [1/s]"] is None]
    if failed:
        x, height = np.array(failed).T
        axes.scatter(x, height, s=14, c=FAILED, marker="x", linewidths=0.9)


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    # Any: the properties of a line have as many types as there are of them.
    dark: dict[str, Any] = {"linestyle": "none", "color": "#444444", "markersize": 5}
    handles = [
        Line2D([], [], marker=AT_TRIM, label="proved, rests at the trim", **dark),
        Line2D([], [], marker=ELSEWHERE, label="proved, rests elsewhere", **dark),
        Line2D([], [], marker="x", label="not proved", **(dark | {"color": FAILED})),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3)
