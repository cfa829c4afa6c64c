"""Campaigns of random runs: bounds used and exceeded, as text, data and a figure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.campaign.motion import BOUNDS
from takagi.certificates.campaign.runs import INSIDE, Campaign
from takagi.models.arrays import Floats
from takagi.reports.figures.style import COLOURS, GREY, figure_to_svg, house_style, new_figure
from takagi.reports.output import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("summary.md", "campaign.json")
OUTSIDE = (
    "Outside of the certificate no bound is promised. The set is left before, or when, one of its\n"
    "peaks is exceeded; named is the other bound that most runs exceed first, and at which winds.\n"
    "Numbers of runs are percentages; overspeed is in percent of rated."
)
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
        if self.inside is not None:
            return bound_rows(self.inside)
        return [beyond_row(campaign) for campaign in self.campaigns]


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
    words = OUTSIDE if report.inside is None else f"{sentence(report.inside)}."
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
        "violations": inside and inside.violations,
        "inside" if inside else "beyond": report.rows,
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
    """Return per bound the largest share used, and violations."""
    return [
        {"bound": name, "largest share": _largest(share), "violations": int(broken.sum())}
        for name, share, broken in zip(BOUNDS, campaign.share, campaign.broken, strict=True)
    ]


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
