"""The published law's map over both overlaps: winds, those at the trim, failures, decay."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.reports.figures.style import GREY, SEQUENTIAL, house_style, new_figure
from takagi.reports.maps.published_rows import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

HATCH = "////"


def overlap_map_figure(found: Grid) -> Figure:
    """Return four maps over eps_T [kN m] and eps_omega [rad/s]; hatched: nothing to show there."""
    from matplotlib.colors import LogNorm, Normalize

    with house_style():
        figure, panels = new_figure(2, 2, width=7.6, height=7.4)
        winds, rates = _finite(found.first_failing), _finite(found.decay)
        fewest = min(*_finite(found.at_trim), *_finite(found.proved), found.winds - 1, found.winds)
        count = Normalize(fewest, found.winds)
        span = (min(winds) - 0.5, max(winds) + 0.5) if winds else (0.0, 1.0)
        decay = _half_decades(rates) if rates else (1e-3, 1e-1)
        _panel(panels[0], found, found.proved, f"winds proved, of {found.winds}", count)
        _panel(panels[1], found, found.at_trim, "of these, at rest at the trim", count)
        _panel(
            panels[2],
            found,
            found.first_failing,
            "first wind not proved [m/s]",
            Normalize(*span),
            nothing="all winds proved",
        )
        _panel(panels[3], found, found.decay, "least proved decay rate [1/s]", LogNorm(*decay))
        for panel in panels[::2]:
            panel.set_ylabel("speed overlap \u03b5$_\u03c9$ [rad/s]")
    return figure


def _half_decades(rates: list[float]) -> tuple[float, float]:
    """Return the half decades around numbers, so that the ticks fit on the colour bar."""
    low, high = (np.log10(end(rates)) for end in (min, max))
    return float(10 ** (np.floor(2 * low) / 2)), float(10 ** (np.floor(2 * high) / 2 + 0.5))


def _finite(values: Floats) -> list[float]:
    return [float(value) for value in values.ravel() if np.isfinite(value)]


def _panel(
    axes: Axes, found: Grid, values: Floats, title: str, norm: Normalize, nothing: str = ""
) -> None:
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle
    from matplotlib.ticker import LogLocator

    x, y = edges(found.torque) / 1e3, edges(found.speed)
    axes.grid(visible=False)
    # One hatched area under all of it: hatched cells would show their seams.
    ground = Rectangle((0, 0), 1, 1, transform=axes.transAxes, hatch=HATCH, zorder=0)
    ground.set(facecolor="white", edgecolor=GREY, linewidth=0)
    axes.add_patch(ground)
    shown = axes.pcolormesh(x, y, np.ma.masked_invalid(values), cmap=SEQUENTIAL, norm=norm)
    axes.set_title(title)
    axes.set_xlabel("torque overlap \u03b5$_T$ [kN m]")
    if np.isfinite(values).any():
        logarithmic = isinstance(norm, LogNorm)
        axes.figure.colorbar(
            shown,
            ax=axes,
            orientation="horizontal",
            pad=0.02,
            aspect=30,
            ticks=LogLocator(subs=(1.0, 2.0, 5.0)) if logarithmic else None,
            format="%g" if logarithmic else None,
        ).minorticks_off()
    if nothing and not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values)).mean(axis=0)
        place = (
            (x[round(column)] + x[round(column) + 1]) / 2,
            (y[round(row)] + y[round(row) + 1]) / 2,
        )
        box = {"facecolor": "white", "edgecolor": "none", "pad": 2}
        axes.annotate(nothing, place, ha="center", va="center", bbox=box)


def edges(values: Floats) -> Floats:
    """Return n + 1 borders half-way between n increasing values; the outer ones as far out."""
    if len(values) == 1:
        return np.array([0.95 * values[0], 1.05 * values[0]])
    middle = (values[1:] + values[:-1]) / 2
    ends = 1.5 * values[[0, -1]] - 0.5 * values[[1, -2]]
    return np.array([ends[0], *middle, ends[1]], dtype=np.float64)
