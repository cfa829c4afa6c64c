"""All files of campaigns, by file name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from takagi.certificates.campaign.runs import Campaign
from takagi.reports.campaign.summary import as_markdown
from takagi.reports.campaign.tables import as_csv, as_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("summary.md", "campaign.json", "runs.csv")


@dataclass(frozen=True, slots=True, eq=False)
class CampaignReport:
    """The campaigns of one certificate.

    Attributes
    ----------
    model, verdict : the turbine's name, and the checker's verdict on the certificate.
    inside : the campaign inside the certified set, or None;  beyond : those outside.
    """

    model: str
    verdict: str
    inside: Campaign | None
    beyond: Sequence[Campaign]

    @property
    def about(self) -> dict[str, Any]:
        """The simulated model and certificate, as plain data."""
        return {"model": self.model, "verdict": self.verdict}


def campaign_files(report: CampaignReport) -> dict[str, bytes | str]:
    """Return file name -> content: summary.md, campaign.json, runs.csv, figures as SVG and PNG.

    The same campaigns give the same bytes.
    """
    from takagi.reports.figures.writing import figure_to_png, figure_to_svg

    figures: dict[str, bytes | str] = {}
    for name, figure in _figures(report).items():
        words = f"{report.model}: random runs, {name}"
        svg = figure_to_svg(figure, name=f"campaign-{name}", description=words)
        figures[f"figures/{name}.svg"] = svg + "\n"
        figures[f"figures/{name}.png"] = figure_to_png(figure, dpi=144)
    names = [*FILES, *figures]
    shown = [name for name in figures if name.endswith(".svg")]
    inside, beyond = report.inside, report.beyond
    every = [*([inside] if inside is not None else []), *beyond]
    return {
        "summary.md": as_markdown(inside, beyond, report.about, shown),
        "campaign.json": as_json(inside, beyond, report.about, names),
        "runs.csv": as_csv(every),
        **figures,
    }


def _figures(report: CampaignReport) -> dict[str, Figure]:
    from takagi.reports.campaign.figures import first_breaks_figure, inside_figure, leaving_figure

    found: dict[str, Figure] = {}
    if report.inside is not None:
        found["inside"] = inside_figure(report.inside)
    if report.beyond:
        found["first-breaks"] = first_breaks_figure(report.beyond)
        # The place where runs leave the set is meaningful only if they begin in it. Only campaigns
        # that widen the whole wind class form an ordered set of lines.
        moved = [c for c in report.beyond if c.beyond.start == 1 and c.broken[0].any()]
        wider = [c for c in moved if c.beyond.name.startswith("wind=")]
        if moved:
            found["leaving"] = leaving_figure(wider or moved[:5])
    return found
