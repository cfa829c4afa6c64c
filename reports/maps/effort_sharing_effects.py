"""Figures of the effort-sharing law's map: what is proved over one axis, or over two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.sweep.axis import Axis
from takagi.certificates.sweep.grid import SweepResult
from takagi.models.arrays import Floats
from takagi.reports.figures.style import COLOURS, GREY, SEQUENTIAL, STYLES, house_style, new_figure
from takagi.reports.maps.effort_sharing_rows import (
    ERROR,
    OVERSPEED,
    RATE,
    column,
    range_names,
    wind_words,
)
from takagi.reports.maps.published_overlaps import edges

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DECAY = "common_decay [1/s]"
MARKS = ("o", "s", "^", "D")
HATCH = "////"


def effect_figure(result: SweepResult) -> Figure:
    """Return wind class, overspeed and decay over the one axis; crosses: nothing proved there."""
    axis = result.map.axes[0]
    x = np.array(axis.values)
    with house_style():
        figure, panels = new_figure(2, 2, width=8.0, height=5.6, share_x=True)
        errors, rates, over, decay = panels
        for k, (_, low, high) in enumerate(range_names(result)):
            look: dict[str, Any] = {"color": COLOURS[k], "linestyle": STYLES[k], "marker": MARKS[k]}
            label = wind_words(low, high)
            errors.plot(x, column(result, "ranges", k, ERROR), label=label, markersize=4, **look)
            rates.plot(x, column(result, "ranges", k, RATE), label=label, markersize=4, **look)
            least = column(result, "ranges", k, "least_decay [1/s]")
            decay.plot(x, least, markersize=4, **look)
        over.plot(x, column(result, OVERSPEED), color=COLOURS[6], marker="o", markersize=4)
        decay.plot(x, column(result, DECAY), color=COLOURS[6], label="one function for all winds")
        if axis.name == "overlap":
            cost = column(result, "energy_cost [%]")
            over.plot(x, cost, color=COLOURS[3], linestyle="--", label="energy cost at rated wind")
            over.legend()
        _dress(errors, "mean |v \u2212 v$_s$| [m/s]")
        _dress(rates, "mean |v$_s$'| [m/s\u00b2]")
        _dress(over, "overspeed bound [%]")
        _dress(decay, "decay rate [1/s]")
        decay.set_yscale("log")
        decay.legend(fontsize=8)
        figure.legend(*errors.get_legend_handles_labels(), loc="outside upper center", ncols=3)
        missing = np.isnan(column(result, OVERSPEED))
        for panel in panels:
            _crosses(panel, x[missing])
        for panel in (over, decay):
            panel.set_xlabel(_label(axis))
    return figure


def side_by_side_figure(results: Sequence[SweepResult]) -> Figure:
    """Return a panel per map of one axis: mean |v - v_s| of the wind class, by range of winds."""
    across = 3
    rows = -(-len(results) // across)
    with house_style():
        figure, panels = new_figure(rows, across, width=9.5, height=2.9 * rows + 0.4)
        for panel in panels[len(results) :]:
            panel.set_axis_off()
        for panel, result in zip(panels, results, strict=False):
            axis = result.map.axes[0]
            x = np.array(axis.values)
            for k, (_, low, high) in enumerate(range_names(result)):
                look: dict[str, Any] = {"color": COLOURS[k], "linestyle": STYLES[k]}
                values = column(result, "ranges", k, ERROR)
                label = wind_words(low, high)
                panel.plot(x, values, label=label, marker=MARKS[k], markersize=4, **look)
            panel.set_ylim(bottom=0.0)
            panel.set_xlabel(_label(axis))
            _dress(panel, "mean |v \u2212 v$_s$| [m/s]")
            _crosses(panel, x[np.isnan(column(result, OVERSPEED))])
        handles = panels[0].get_legend_handles_labels()
        figure.legend(*handles, loc="outside upper center", ncols=3)
    return figure


def pair_figure(result: SweepResult) -> Figure:
    """Return maps of wind class, overspeed and decay over two axes; hatched: not proved."""
    first, second = result.map.axes
    shape = len(first.values), len(second.values)
    x, y = edges(np.array(second.values)), edges(np.array(first.values))
    shown: list[tuple[str, tuple[str | int, ...]]] = [
        (f"mean |v \u2212 v$_s$| [m/s], {wind_words(low, high)}", ("ranges", k, ERROR))
        for k, (_, low, high) in enumerate(range_names(result))
    ]
    shown += [("overspeed bound [%]", (OVERSPEED,)), ("common decay rate [1/s]", (DECAY,))]
    with house_style():
        figure, panels = new_figure(2, 3, width=10.0, height=6.4)
        for panel in panels[len(shown) :]:
            panel.set_axis_off()
        for panel, (title, keys) in zip(panels, shown, strict=False):
            values = column(result, *keys).reshape(shape)
            panel.grid(visible=False)
            lost = np.ma.masked_invalid(np.where(np.isfinite(values), np.nan, 1.0))
            panel.pcolor(x, y, lost, hatch=HATCH, cmap="binary", vmin=1, vmax=9)
            if np.isfinite(values).any():
                # The scale starts at 0: otherwise nearly constant values would look different.
                seen = np.ma.masked_invalid(values)
                drawn = panel.pcolormesh(x, y, seen, cmap=SEQUENTIAL, vmin=0.0)
                figure.colorbar(drawn, ax=panel, orientation="horizontal", pad=0.02, aspect=30)
            panel.set_title(title)
            panel.set_xlabel(_label(second))
            panel.set_ylabel(_label(first))
    return figure


def _label(axis: Axis) -> str:
    return f"{axis.name} [{axis.unit}]".replace("^2", "\u00b2")


def _dress(axes: Axes, label: str) -> None:
    axes.set_ylabel(label)
    axes.margins(x=0.03)


def _crosses(axes: Axes, x: Floats) -> None:
    """Mark points where nothing is proved, on the lower edge."""
    if len(x):
        axes.plot(
            x,
            np.zeros(len(x)),
            transform=axes.get_xaxis_transform(),
            color=GREY,
            marker="x",
            linestyle="none",
            clip_on=False,
        )
