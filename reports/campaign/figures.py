"""Campaigns as figures: use of the bounds inside; runs that leave the set outside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.campaign.bounds import BOUNDS, DECAYS
from takagi.certificates.campaign.first_breaks import TABLE, first_breaks
from takagi.certificates.campaign.runs import Campaign
from takagi.models.arrays import Floats
from takagi.reports.figures.style import COLOURS, GREY, house_style, new_figure, shades, wind_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The ratios in the first panel: those that depend on more than the start itself.
SHOWN = ("set", "speed error", "effort lag", "torque asked")


def inside_figure(campaign: Campaign) -> Figure:
    """Return the largest shares late in the runs over their start wind, and the decays' range."""
    records = campaign.records
    with house_style():
        figure, panels = new_figure(2, 1, height=5.6, share_x=True)
        for colour, name in zip(COLOURS, SHOWN, strict=False):
            row = records.late_share[BOUNDS.index(name)]
            panels[0].plot(
                *_envelope(campaign, row), color=colour, label=name, drawstyle="steps-mid"
            )
        for colour, name in zip(COLOURS, DECAYS, strict=False):
            row = records.share[BOUNDS.index(name)]
            middle, most = _envelope(campaign, row)
            _, least = _envelope(campaign, -row)
            panels[1].fill_between(
                middle, -least, most, step="mid", color=colour, alpha=0.3, linewidth=0
            )
            panels[1].plot(middle, most, color=colour, label=name, drawstyle="steps-mid")
        for axes, label in zip(
            panels,
            (
                "largest share of the bound,\nsecond half of the runs",
                "certified over\nobserved decay rate",
            ),
            strict=True,
        ):
            axes.axhline(1.0, color=GREY, linestyle="--", linewidth=1.0)
            axes.set_ylim(0, 1.1)
            axes.set_ylabel(label)
            axes.legend(ncols=2)
        wind_axis(panels[-1])
        panels[-1].set_xlabel("schedule wind at the start [m/s]")
        panels[0].set_title(f"{campaign.runs} runs inside the certified set; the bound is 1")
        figure.align_ylabels(panels)
    return figure


def leaving_figure(campaigns: Sequence[Campaign]) -> Figure:
    """Return per campaign the fraction of runs that leave the set, over the wind there."""
    with house_style():
        figure, (axes,) = new_figure(1, 1, height=3.8)
        loop = campaigns[0].loop
        edges = np.arange(np.floor(loop.wind[0]), np.ceil(loop.wind[-1]) + 1)
        for colour, campaign in zip(shades(len(campaigns)), campaigns, strict=True):
            winds = campaign.records.broken_wind[0]
            counts, _ = np.histogram(winds[~np.isnan(winds)], edges)
            axes.stairs(
                100 * counts / campaign.runs, edges, color=colour, label=campaign.beyond.name,
                linewidth=1.6,
            )  # fmt: skip
        axes.set_ylabel("runs that leave the set there\n[% of all, per m/s]")
        wind_axis(axes)
        axes.set_xlabel("schedule wind where V passes 1 [m/s]")
        axes.set_xlim(edges[0], edges[-1])
        axes.set_ylim(bottom=0)
        axes.legend()
    return figure


def first_breaks_figure(campaigns: Sequence[Campaign]) -> Figure:
    """Return per campaign the first bound exceeded, the set excepted, as fractions of all runs."""
    names = (*BOUNDS, TABLE)
    parts = np.array(
        [[np.mean(first_breaks(c) == i) for i in range(len(names))] for c in campaigns]
    )
    seen = [i for i in range(len(names)) if parts[:, i].any()]
    with house_style():
        figure, (axes,) = new_figure(1, 1, height=1.4 + 0.32 * len(campaigns))
        left = np.zeros(len(campaigns))
        places = np.arange(len(campaigns))
        for i, colour in zip(seen, (*COLOURS, "#999999", "#F0E442"), strict=False):
            axes.barh(places, 100 * parts[:, i], left=left, color=colour, label=names[i])
            left += 100 * parts[:, i]
        axes.set_yticks(places, [c.beyond.name for c in campaigns])
        axes.invert_yaxis()
        axes.set_xlabel("runs by the first bound that breaks, the set aside [%]")
        axes.set_xlim(0, max(100.0 if left.max() > 60 else 1.1 * left.max(), 1.0))
        axes.grid(visible=False, axis="y")
        if seen:
            figure.legend(loc="outside upper center", ncols=min(len(seen), 4))
    return figure


def _envelope(campaign: Campaign, row: Floats) -> tuple[Floats, Floats]:
    """Return the largest value of a row over 44 equal bins of wind."""
    loop, start = campaign.loop, campaign.records.start_wind
    edges = np.linspace(loop.wind[0], loop.wind[-1], 45)
    cell = np.clip(np.searchsorted(edges, start, side="right") - 1, 0, len(edges) - 2)
    found = np.full(len(edges) - 1, np.nan)
    for k in range(len(found)):
        own = row[(cell == k) & ~np.isnan(row)]
        if len(own):
            found[k] = own.max()
    return (edges[:-1] + edges[1:]) / 2, found
