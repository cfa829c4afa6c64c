"""The page of campaigns, in Markdown: the runs, the use of each bound, the violations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from takagi.certificates.campaign.runs import Campaign
from takagi.reports.campaign.tables import (
    beyond_row,
    bound_rows,
    first_words,
    player_rows,
    sentence,
)

READING = (
    "A share of 1 is the bound itself. Starts lie on the boundary and where each bound is "
    'attained; "late" is the second half of the runs, when the start is forgotten and wind and '
    "plant are all that acts. A decay's share is the certified over the observed mean rate. Step "
    "halving is the largest difference that steps half as long make to a share."
)
OUTSIDE = (
    "No bound is promised here. The set is left before, or when, one of its peaks is exceeded; "
    "of the other bounds the one that most runs break first is named, with the schedule winds at "
    "which it breaks."
)


def as_markdown(
    inside: Campaign | None,
    beyond: Sequence[Campaign],
    about: dict[str, Any],
    figures: Sequence[str],
) -> str:
    """Return the tables with the explanations needed to read them.

    Parameters
    ----------
    about : what was simulated: model and verdict;  figures : file names that are shown.
    """
    lines = [
        f"# Random runs of the loop of {about['model']}",
        "",
        f"Certificate: {about['verdict']}.",
    ]
    if inside is not None:
        lines += ["", "## Inside the certified set", "", *_inside(inside)]
    if beyond:
        lines += ["", "## Outside", "", OUTSIDE, "", *_outside(beyond)]
    for figure in figures:
        lines += ["", f"![{figure}]({figure})"]
    return "\n".join(lines) + "\n"


def _inside(campaign: Campaign) -> list[str]:
    bounds = [
        f"| {row['bound']} | {_escaped(row['about'])} | {_cell(row['largest_share'])} | "
        f"{_cell(row['largest_share_late'])} | {row['violations']} | {row['step_halving']:.0e} |"
        for row in bound_rows(campaign)
    ]
    winds = [
        f"| {row['winds']} | {row['runs']} | {_cell(row['largest_value_late'])} | "
        f"{row['overspeed']:.2f} |"
        for row in player_rows(campaign)
    ]
    return [
        f"{sentence(campaign)}.",
        "",
        "| bound | | largest share | late | violations | step halving |",
        "|---|---|---:|---:|---:|---:|",
        *bounds,
        "",
        READING,
        "",
        "| winds | runs | V late | overspeed [%] |",
        "|---|---:|---:|---:|",
        *winds,
    ]


def _outside(campaigns: Sequence[Campaign]) -> list[str]:
    rows = [
        f"| {row['beyond']} | {100 * row['left_set']:.1f} % | {first_words(row)} | "
        f"{row['largest_value']:.3g} | {row['overspeed']:.2f} | "
        f"{100 * row['left_table']:.1f} % | {100 * row['inside_at_end']:.1f} % |"
        for row in map(beyond_row, campaigns)
    ]
    return [
        "| beyond | leave the set | first other bound | V up to | overspeed [%] | leave the table "
        "| in the set at the end |",
        "|---|---:|---|---:|---:|---:|---:|",
        *rows,
    ]


def _escaped(words: str) -> str:
    """Return text for a Markdown cell, with bars escaped because a bar ends the cell."""
    return words.replace("|", "\\|")


def _cell(value: float | None) -> str:
    return "–" if value is None else f"{value:.4f}"
