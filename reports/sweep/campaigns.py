"""What a sweep and a campaign leave: page, points as CSV, figures; bounds used and exceeded."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.campaign.motion import BOUNDS
from takagi.certificates.campaign.runs import INSIDE, Campaign
from takagi.certificates.sweep.sweep import Sweep
from takagi.models.arrays import Floats
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    figure_to_svg,
    house_style,
    new_figure,
    shades,
)
from takagi.reports.output import markdown_page, rows_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("summary.md", "campaign.json")
NO_VIOLATION = "no violation of any certified bound"
# As many as there are bounds but the set.
BAR_COLOURS = (*COLOURS, "#999999", "#F0E442", "#8C564B", "#004D40")
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
        if self.inside is None:
            return [beyond_row(campaign) for campaign in self.campaigns]
        pairs = zip(BOUNDS, self.inside.share, self.inside.broken, strict=True)
        return [
            {"bound": name, "largest share": _largest(share), "violations": int(broken.sum())}
            for name, share, broken in pairs
        ]


def campaign_files(report: CampaignReport) -> dict[str, bytes | str]:
    """Return file name -> content: ``FILES`` and a figure.  The same runs give the same bytes."""
    name = "first-breaks" if report.inside is None else "inside"
    words, file = f"{report.model}: random runs, {name}", f"figures/{name}.svg"
    figure = campaign_figure(report)
    return {
        "summary.md": f"{as_text(report)}\n![{words}]({file})\n",
        "campaign.json": as_json(report, [*FILES, file]),
        file: figure_to_svg(figure, name=f"campaign-{name}", description=words) + "\n",
    }


def as_text(report: CampaignReport) -> str:
    """Return the table with the explanations needed to read it, as Markdown."""
    words, inside = "", report.inside
    if inside is not None:
        hours, broken = inside.runs * inside.duration / 3600, inside.violations
        result = f"{broken} violate a certified bound" if broken else NO_VIOLATION
        words = f"{inside.runs} runs of {inside.duration:g} s ({hours:.0f} h of operation): "
        words += result
    return markdown_page("sweep", "campaign", report=report, sentence=words)


def as_json(report: CampaignReport, files: Sequence[str]) -> str:
    """Return all results as JSON; the same campaigns give the same text."""
    first, inside = report.campaigns[0], report.inside
    content = {
        "model": report.model,
        "verdict": report.verdict,
        "runs": first.runs,
        "duration [s]": first.duration,
        "seed": first.seed,
        "violations": inside and inside.violations,
        "inside" if inside else "beyond": report.rows,
        "files": list(files),
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def beyond_row(campaign: Campaign) -> Row:
    """Return the results of a campaign outside the certified class, as percentages of its runs."""
    shares, events = first_breaks(campaign), campaign.events
    i = int(np.argmax(shares))
    winds = events["first_wind"][events["first"] == i]
    inside = (events["end_value"] <= 1) & ~campaign.broken[BOUNDS.index("coefficient table")]
    return {
        "beyond": campaign.beyond.name,
        "leave set": 100 * float(np.mean(campaign.broken[0])),
        "set at end": 100 * float(np.mean(inside)),
        "V up to": _largest(campaign.share[0]),
        "overspeed": float(campaign.overspeed.max()),
        "first other bound": BOUNDS[i] if len(winds) else None,
        "of runs": float(shares[i]),
        "at [m/s]": f"{winds.min():.1f} to {winds.max():.1f}" if len(winds) else None,
    }


def first_breaks(campaign: Campaign) -> Floats:
    """Return the percentage of runs that exceed each bound first, the set excepted."""
    first = campaign.events["first"]
    return 100 * np.array([np.mean(first == i) for i in range(len(BOUNDS))])


def campaign_figure(report: CampaignReport) -> Figure:
    """Return bars: inside the class the largest share of each bound.

    Outside, for each campaign, the percentages of runs by the bound that is exceeded first.
    """
    names: Sequence[str] = BOUNDS
    if report.inside is not None:
        title, limit = f"{report.inside.runs} runs inside the certified class; the bound is 1", 1.1
        shares = np.array([[_largest(share) or 0.0] for share in report.inside.share])
        parts = {"largest share of the bound": shares[:, 0]}
    else:
        names = [campaign.beyond.name for campaign in report.campaigns]
        shares = np.array([first_breaks(campaign) for campaign in report.campaigns])
        parts = {name: shares[:, i] for i, name in enumerate(BOUNDS) if shares[:, i].any()}
        title, limit = "runs by the first bound that is exceeded, the set excepted [%]", 100.0
    with house_style():
        figure, (axes,) = new_figure(height=1.4 + 0.32 * len(names))
        offset = np.zeros(len(names))
        for (label, lengths), colour in zip(parts.items(), BAR_COLOURS, strict=False):
            axes.barh(names, lengths, left=offset, color=colour, label=label)
            offset = offset + lengths
        axes.axvline(limit if report.inside is None else 1.0, color=GREY, linestyle="--")
        axes.invert_yaxis()
        axes.set(title=title, xlim=(0, limit))
        axes.grid(visible=False, axis="y")
        if parts:
            figure.legend(loc="outside lower center", ncols=min(len(parts), 4))
    return figure


def _largest(values: Floats) -> float | None:
    """Return the largest number that JSON can represent; None if there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.max()) if len(finite) else None


# The columns that page and figure show, and the one that the figure draws in decades.
PUBLISHED = (
    *("proved_windows", "proved_at_trim", "first_failing_wind [m/s]"),
    "least_decay_rate [1/s]",
)
EFFORT_SHARING = (
    *("overspeed [%]", "common_decay [1/s]", "mean_wind_error [m/s]", "mean_wind_rate [m/s^2]"),
)
DECADES = "least_decay_rate [1/s]"
MOST_LABELS = 8


def sweep_files(sweep: Sweep) -> dict[str, bytes | str]:
    """Return file name -> content: map.md, points.csv, for published laws windows.csv, a figure."""
    heads = [axis.label for axis in sweep.axes]
    points = [{k: v for k, v in row.items() if k != "windows"} for row in sweep.rows]
    windows = [
        {head: row[head] for head in heads} | window
        for row in sweep.rows
        for window in row.get("windows", ())
    ]
    files: dict[str, bytes | str] = {"points.csv": rows_csv(points)}
    if windows:
        files["windows.csv"] = rows_csv(windows)
    picture, figure = "", sweep_figure(sweep)
    if figure is not None:
        words = f"{law_words(sweep.law)} over " + " and ".join(axis.name for axis in sweep.axes)
        files["figures/map.svg"] = figure_to_svg(figure, name="sweep-map", description=words)
        picture = words
    shown = [*heads, "verdict", *_columns(sweep), "reason"]
    counted = ", ".join(f"{number} {verdict}" for verdict, number in sweep.counted().items())
    rows = [{head: row.get(head) for head in shown} for row in sweep.rows]
    told = {"law": law_words(sweep.law), "counted": counted, "picture": picture}
    files["map.md"] = markdown_page("sweep", "map", sweep=sweep, rows=rows, **told)
    return files


def sweep_figure(sweep: Sweep) -> Figure | None:
    """Return a panel for each column, over the last axis; a line for each value of the others.

    A point without a number is a gap.  None if the last axis has one value, or without a number.
    """
    if not sweep.axes or len(sweep.axes[-1].values) < 2:
        return None
    axis, drawn = sweep.axes[-1], {}
    for column in _columns(sweep):
        values = np.array([row.get(column) for row in sweep.rows], dtype=np.float64)
        if np.isfinite(values).any():
            drawn[column] = values.reshape(-1, len(axis.values))
    if not drawn:
        return None
    starts = sweep.rows[:: len(axis.values)]
    with house_style():
        figure, panels = new_figure(2, 2, height=5.6)
        for panel, (column, lines) in zip(panels, drawn.items(), strict=False):
            for line, colour in zip(lines, shades(len(lines)), strict=True):
                panel.plot(axis.values, line, color=colour, marker="o", markersize=4)
            margin = 0.03 * (axis.values[-1] - axis.values[0])
            limits = (axis.values[0] - margin, axis.values[-1] + margin)
            panel.set(title=column.replace("_", " "), xlabel=axis.label, xlim=limits)
            if column == DECADES:
                panel.set_yscale("log")
            else:
                panel.set_ylim(0.0, 1.08 * float(np.nanmax(lines)) or 1.0)
        for panel in panels[len(drawn) :]:
            panel.set_axis_off()
        for k in range(0, len(starts), -(-len(starts) // MOST_LABELS)) if len(starts) > 1 else ():
            at = (f"{other.name} {starts[k][other.label]:g}" for other in sweep.axes[:-1])
            panels[0].lines[k].set_label(", ".join(at))
        if len(starts) > 1:
            figure.legend(loc="outside upper center", ncols=4)
    return figure


def _columns(sweep: Sweep) -> Sequence[str]:
    return EFFORT_SHARING if sweep.law == "coherent" else PUBLISHED
