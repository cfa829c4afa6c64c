"""The certified quantities over wind: one step per wind cell; gaps stay visible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.figures.style import COLOURS, columns, house_style, new_figure, wind_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cells_figure(
    edges: ArrayLike,
    proved: ArrayLike,
    *,
    decay_rate: ArrayLike,
    wind_rate: ArrayLike,
    overspeed: ArrayLike,
    title: str = "",
) -> Figure:
    """Return decay rate, wind class and overspeed bound per wind cell.

    Parameters
    ----------
    edges : (n + 1,) of the cells [m/s], increasing.
    proved : (n,) of bool; a cell that is not proved is hatched and shows no figure.
    decay_rate : (n,) [1/s].
    wind_rate : (n,) largest |v'| of the class [m/s^2].
    overspeed : (n,) bound on omega above its reference, as a share of rated [-]; shown in percent.

    Raises
    ------
    ModelError : lengths that do not fit the edges.
    """
    v = np.asarray(edges, dtype=np.float64)
    sound = np.asarray(proved, dtype=bool)
    if v.ndim != 1 or len(v) < 2 or sound.shape != (len(v) - 1,):
        raise ModelError(
            f"edges have shape {v.shape}, proved {sound.shape}; n + 1 edges bound n cells"
        )
    figures = columns("cells", [decay_rate, wind_rate, overspeed], len(sound))
    labels = ("decay rate\n[1/s]", "wind class |v'|\n[m/s²]", "overspeed bound\n[%]")
    with house_style():
        figure, panels = new_figure(3, 1, height=5.2, share_x=True)
        for axes, values, label, factor in zip(
            panels, figures, labels, (1.0, 1.0, 100.0), strict=True
        ):
            shown = cells_panel(axes, v, factor * values, sound)
            if sound.any():
                axes.set_ylim(0.0, 1.15 * max(float(np.nanmax(shown)), 1e-9))
            axes.set_ylabel(label)
        wind_axis(panels[-1])
        panels[-1].set_xlim(v[0], v[-1])
        panels[0].set_title(title)
        figure.align_ylabels(panels)
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
