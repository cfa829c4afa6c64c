"""Campaigns of random runs: bounds used and exceeded, as text, data and figures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.campaign.motion import BOUNDS
from takagi.certificates.campaign.runs import INSIDE, Campaign
from takagi.models.arrays import Floats
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    figure_to_svg,
    house_style,
    new_figure,
    wind_axis,
)
from takagi.reports.page.markdown_table import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("summary.md", "campaign.json")
BREAKS = (*BOUNDS, "coefficient table")
LATE = "Late: the second half of the runs, when the start is forgotten."
OUTSIDE = (
    "Outside of the certificate no bound is promised. The set is left before, or when, one of its\n"
    "peaks is exceeded; named is the other bound that most runs exceed first, and at which winds.\n"
    "Numbers of runs are percentages; overspeed is in percent of rated."
)
# The ratios in the first panel: those that depend on more than the start itself.
OVER_WIND = ("set", "speed error", "effort lag", "torque asked")
BINS = 44
Row = dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class CampaignReport:
    """The campaigns of one certificate: either one inside the certified class, or some outside.

    ``model`` and ``verdict`` are the turbine's name, and the checker's verdict on the certificate.
    """

    model: str
    verdict: str
    campaigns: Sequence[Campaign]

    @property
    def inside(self) -> Campaign | None:
        """The campaign inside the certified class."""
        return self.campaigns[0] if self.campaigns[0].beyond == INSIDE else None

    @property
    def rows(self) -> list[Row]:
        """A row for each bound inside the certified class, or for each campaign outside."""
        if self.inside is not None:
            return bound_rows(self.inside)
        return [beyond_row(campaign) for campaign in self.campaigns]


def campaign_files(report: CampaignReport) -> dict[str, bytes | str]:
    """Return file name -> content: ``FILES`` and a figure.  The same runs give the same bytes."""
    if report.inside is not None:
        name, figure = "inside", inside_figure(report.inside)
    else:
        name, figure = "first-breaks", first_breaks_figure(report.campaigns)
    words, file = f"{report.model}: random runs, {name}", f"figures/{name}.svg"
    svg = figure_to_svg(figure, name=f"campaign-{name}", description=words)
    return {
        "summary.md": f"{as_text(report)}\n![{words}]({file})\n",
        "campaign.json": as_json(report, [*FILES, file]),
        file: svg + "\n",
    }


def as_text(report: CampaignReport) -> str:
    """Return the table with the explanations needed to read it, as Markdown."""
    words = OUTSIDE if report.inside is None else f"{sentence(report.inside)}.\n{LATE}"
    return (
        f"# {report.model}: random runs of the certified loop\n\nCertificate: {report.verdict}.\n\n"
        f"{markdown_table(report.rows)}\n{words}\nA simulation proves nothing.\n"
    )


def as_json(report: CampaignReport, files: Sequence[str]) -> str:
    """Return all results as JSON; the same campaigns give the same text."""
    first, inside = report.campaigns[0], report.inside
    content = {
        "model": report.model,
        "verdict": report.verdict,
        "runs": first.runs,
        "duration [s]": first.duration,
        "seed": first.seed,
        "inside": inside and {"violations": inside.violations, "bounds": report.rows},
        "beyond": [] if inside else report.rows,
        "files": list(files),
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def sentence(campaign: Campaign) -> str:
    """Return a one-line summary of a campaign inside the certified class."""
    hours = campaign.runs * campaign.duration / 3600
    summary = f"{campaign.runs} runs of {campaign.duration:g} s ({hours:.0f} h of operation)"
    if campaign.violations:
        return f"{summary}: {campaign.violations} violate a certified bound"
    return f"{summary}: no violation of any certified bound"


def bound_rows(campaign: Campaign) -> list[Row]:
    """Return per bound the largest share used, the same late in the runs, and violations."""
    return [
        {
            "bound": name,
            "largest share": _largest(campaign.share[i]),
            "late": _largest(campaign.late[i]),
            "violations": int(campaign.broken[i].sum()),
        }
        for i, name in enumerate(BOUNDS)
    ]


def beyond_row(campaign: Campaign) -> Row:
    """Return the results of a campaign outside the certified class, as percentages of its runs."""
    shares, events = first_breaks(campaign), campaign.events
    i = int(np.argmax(shares))
    winds = events["first_wind"][events["first"] == i]
    inside = (events["end_value"] <= 1) & np.isnan(events["lost_at"])
    return {
        "beyond": campaign.beyond.name,
        "leave set": 100 * float(np.mean(np.isfinite(events["left_at"]))),
        "set at end": 100 * float(np.mean(inside)),
        "V up to": _largest(campaign.share[0]),
        "overspeed": float(campaign.overspeed.max()),
        "first other bound": BREAKS[i] if len(winds) else None,
        "of runs": float(shares[i]),
        "at [m/s]": f"{winds.min():.1f} to {winds.max():.1f}" if len(winds) else None,
    }


def first_breaks(campaign: Campaign) -> Floats:
    """Return the percentage of runs that exceed each of ``BREAKS`` first, the set set aside."""
    first = campaign.events["first"]
    return 100 * np.array([np.mean(first == i) for i in range(len(BREAKS))])


def inside_figure(campaign: Campaign) -> Figure:
    """Return the largest shares late in the runs over their start wind, and those of the decays."""
    lines = [(0, name, campaign.late) for name in OVER_WIND]
    lines += [(1, name, campaign.share) for name in BOUNDS[-2:]]
    with house_style():
        figure, panels = new_figure(2, 1, height=5.6, share_x=True)
        for k, name, rows in lines:
            winds, largest = _envelope(campaign, rows[BOUNDS.index(name)])
            colour = COLOURS[len(panels[k].lines)]
            panels[k].plot(winds, largest, color=colour, label=name, drawstyle="steps-mid")
        for axes in panels:
            axes.axhline(1.0, color=GREY, linestyle="--", linewidth=1.0)
            axes.set_ylim(0, 1.1)
            axes.legend(ncols=2)
        panels[0].set_title(f"{campaign.runs} runs inside the certified class; the bound is 1")
        panels[0].set_ylabel("largest share of the bound,\nsecond half of the runs")
        panels[1].set_ylabel("certified over\nobserved decay rate")
        wind_axis(panels[1])
        panels[1].set_xlabel("schedule wind at the start [m/s]")
        figure.align_ylabels(panels)
    return figure


def first_breaks_figure(campaigns: Sequence[Campaign]) -> Figure:
    """Return per campaign the first bound exceeded, the set excepted, as percentages of runs."""
    shares = np.array([first_breaks(campaign) for campaign in campaigns])
    with house_style():
        figure, (axes,) = new_figure(1, 1, height=1.4 + 0.32 * len(campaigns))
        heights, offset = np.arange(len(campaigns)), np.zeros(len(campaigns))
        exceeded = [i for i in range(len(BREAKS)) if shares[:, i].any()]
        for i, colour in zip(exceeded, (*COLOURS, "#999999", "#F0E442"), strict=False):
            axes.barh(heights, shares[:, i], left=offset, color=colour, label=BREAKS[i])
            offset = offset + shares[:, i]
        axes.set_yticks(heights, [campaign.beyond.name for campaign in campaigns])
        axes.invert_yaxis()
        axes.set_xlabel("runs by the first bound that is exceeded, the set aside [%]")
        axes.set_xlim(0, 100 if offset.max() > 60 else max(1.1 * offset.max(), 1.0))
        axes.grid(visible=False, axis="y")
        if exceeded:
            figure.legend(loc="outside upper center", ncols=min(len(exceeded), 4))
    return figure


def _envelope(campaign: Campaign, values: Floats) -> tuple[Floats, Floats]:
    """Return the largest value over equal bins of the start wind."""
    start, wind = campaign.events["start_wind"], campaign.loop.wind
    edges = np.linspace(wind[0], wind[-1], BINS + 1)
    bins = np.clip(np.searchsorted(edges, start, side="right") - 1, 0, BINS - 1)
    largest = [_largest(values[bins == k]) for k in range(BINS)]
    return (edges[:-1] + edges[1:]) / 2, np.array(largest, dtype=np.float64)


def _largest(values: Floats) -> float | None:
    """Return the largest number that JSON can represent; None if there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.max()) if len(finite) else None
