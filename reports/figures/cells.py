"""What is certified over wind, and for which overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.models.arrays import Floats
from takagi.reports.figures.style import COLOURS, columns, house_style, new_figure, wind_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cells_figure(
    edges: ArrayLike,
    proved: ArrayLike,
    *,
    decay_rate: ArrayLike,
    wind_error: ArrayLike,
    wind_rate: ArrayLike,
    overspeed: ArrayLike,
) -> Figure:
    """Return decay rate, wind limits and overspeed bound per wind cell.

    edges : (n + 1,) of the cells [m/s], increasing.
    proved : (n,) of bool; a cell that is not proved is hatched and shows no figure.
    decay_rate : (n,) [1/s].
    wind_error, wind_rate : (n,) largest |v - v_s| [m/s] and |v_s'| [m/s^2] of the wind limits.
    overspeed : (n,) bound on omega above its reference, as a share of rated [-]; shown in percent.
    """
    v = np.asarray(edges, dtype=np.float64)
    sound = np.asarray(proved, dtype=bool)
    figures = columns("cells", [decay_rate, wind_error, wind_rate, overspeed], len(sound))
    labels = (
        "decay rate\n[1/s]",
        "|v \u2212 v$_s$| up to\n[m/s]",
        "|v$_s$'| up to\n[m/s²]",
        "overspeed bound\n[%]",
    )
    with house_style():
        figure, panels = new_figure(4, 1, height=6.2, share_x=True)
        for axes, values, label, factor in zip(
            panels, figures, labels, (1.0, 1.0, 1.0, 100.0), strict=True
        ):
            shown = cells_panel(axes, v, factor * values, sound)
            if sound.any():
                axes.set_ylim(0.0, 1.15 * max(float(np.nanmax(shown)), 1e-9))
            axes.set_ylabel(label)
        wind_axis(panels[-1])
        panels[-1].set_xlim(v[0], v[-1])
        if not sound.all():
            handles, texts = panels[0].get_legend_handles_labels()
            figure.legend(handles, texts, loc="outside lower center")
    return figure


def cells_panel(axes: Axes, edges: Floats, values: ArrayLike, sound: NDArray[np.bool_]) -> Floats:
    """Draw a step per cell, hatched where it is not proved; return the values, nan there."""
    heights = np.where(sound, values, np.nan)
    if sound.any():
        axes.stairs(heights, edges, baseline=0.0, fill=True, color=COLOURS[0], alpha=0.25)
        axes.stairs(heights, edges, baseline=None, color=COLOURS[0], linewidth=1.6)
    label = "not proved"
    for low, high, fine in zip(edges[:-1], edges[1:], sound, strict=True):
        if not fine:
            axes.axvspan(
                low,
                high,
                facecolor="none",
                edgecolor=COLOURS[1],
                hatch="////",
                linewidth=0.0,
                label=label,
            )
            label = "_nolegend_"
    return heights


# Narrower than this share of the axis a range could not be seen.
NARROWEST_SHARE = 0.014
# Any: the properties of a patch have as many types as there are of them.
PROVED: dict[str, Any] = {"facecolor": COLOURS[0], "edgecolor": COLOURS[0], "linewidth": 0.0}
UNPROVED: dict[str, Any] = {
    "facecolor": "white",
    "edgecolor": COLOURS[1],
    "linewidth": 0.8,
    "hatch": "//////",
}


@dataclass(frozen=True, slots=True)
class OverlapRow:
    """One bar: its label, and the winds [m/s] proved, and those examined but not proved."""

    label: str
    proved: tuple[tuple[float, float], ...]
    unproved: tuple[tuple[float, float], ...]


def overlaps_figure(rows: Sequence[OverlapRow], *, wind: tuple[float, float]) -> Figure:
    """Return horizontal bars over wind [m/s]: proved ranges filled, other examined ones hatched.

    A range too narrow to be seen is drawn lower and wider than it is, about its middle.  What is
    not proved lies on top, so that no widened bar hides it.

    rows : from top to bottom.
    wind : the ends of the axis [m/s].
    """
    from matplotlib.patches import Patch, Rectangle

    with house_style():
        figure, (axes,) = new_figure(height=1.15 + 0.3 * len(rows))
        narrowest = NARROWEST_SHARE * (wind[1] - wind[0])
        for index, row in enumerate(rows):
            for spans, style in ((row.proved, PROVED), (row.unproved, UNPROVED)):
                for low, high in spans:
                    tall = 0.62 if high - low >= narrowest else 0.42
                    width, middle = max(high - low, narrowest), (low + high) / 2
                    corner = (middle - width / 2, index - tall / 2)
                    axes.add_patch(Rectangle(corner, width, tall, **style))
        axes.set_yticks(range(len(rows)), [row.label for row in rows])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        # Room for a widened bar at either end.
        axes.set_xlim(wind[0] - narrowest, wind[1] + narrowest)
        axes.set_ylabel("overlaps\n\u03b5$_\u03c9$ [rad/s], \u03b5$_T$ [N m]")
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        wind_axis(axes)
        handles = [
            Patch(label="proved", **PROVED),
            Patch(label="looked at, not proved", **UNPROVED),
        ]
        axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure
