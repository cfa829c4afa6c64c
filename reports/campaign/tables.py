"""The numbers of campaigns: bounds used and broken, as rows, JSON and CSV."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from takagi.certificates.campaign.bounds import BOUNDS
from takagi.certificates.campaign.first_breaks import TABLE, breaks_of, overspeed
from takagi.certificates.campaign.outside import INSIDE
from takagi.certificates.campaign.runs import Campaign
from takagi.certificates.campaign.winds import PLAYERS
from takagi.reports.csv_text import csv_text

# Bound -> the quantity of its ratio, for the table.
ABOUT = {
    "set": "V ≤ 1",
    "speed error": "|e| ≤ p_e",
    "effort lag": "|ζ| ≤ p_ζ",
    "speed signal": "|e − x| ≤ p_s",
    "integral": "|x| ≤ p_x",
    "rotor speed": "ω ≤ max ω* + p_e",
    "torque asked": "torque asked ≥ 0, before its limiter",
    "pitch asked": "pitch asked ≤ β_max, before its limiter",
    "least pitch": "β ≥ β_min",
    "decay": "falls at d_k or faster, constant wind",
    "common decay": "falls at d or faster, constant wind",
}


def bound_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Return per bound: largest share used, the same late in the runs, violations, halving."""
    records, found = campaign.records, []
    for i, name in enumerate(BOUNDS):
        found.append(
            {
                "bound": name,
                "about": ABOUT[name],
                "runs": int(np.count_nonzero(~np.isnan(records.share[i]))),
                "largest_share": _number(campaign.largest(name)),
                "largest_share_late": _largest(records.late_share[i]),
                "violations": int(campaign.broken[i].sum()),
                "step_halving": float(records.halving[i]),
            }
        )
    return found


def player_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Return per kind of wind: runs, largest V late in the runs, overspeed [%], violations."""
    records, found = campaign.records, []
    over, broken = 100 * overspeed(campaign), np.asarray(campaign.broken.any(axis=0))
    for i, name in enumerate(PLAYERS):
        own = records.player == i
        if own.any():
            found.append(
                {
                    "winds": name,
                    "runs": int(own.sum()),
                    "largest_value_late": _largest(records.late_share[0, own]),
                    "overspeed": float(over[own].max()),
                    "violations": int(broken[own].sum()),
                }
            )
    return found


def beyond_row(campaign: Campaign) -> dict[str, Any]:
    """Return the results of a campaign outside the certified class, as one row."""
    records, runs = campaign.records, campaign.runs
    breaks = breaks_of(campaign)
    others = [b for b in breaks if b.bound != "set" and b.first]
    first = max(others, key=lambda b: b.first) if others else None
    left = next((b for b in breaks if b.bound == "set"), None)
    counts = {b.bound: b.runs for b in breaks}
    return {
        "beyond": campaign.beyond.name,
        "runs": runs,
        "left_set": counts.get("set", 0) / runs,
        "left_set_winds": None if left is None else list(left.wind),
        "first": None if first is None else first.bound,
        "first_runs": 0.0 if first is None else first.first / runs,
        "first_winds": None if first is None else list(first.wind),
        "any_other_bound": sum(b.first for b in others) / runs,
        "torque_asked": counts.get("torque asked", 0) / runs,
        "left_table": counts.get(TABLE, 0) / runs,
        "largest_value": _largest(records.share[0]),
        "overspeed": float(100 * overspeed(campaign).max()),
        "inside_at_end": float(np.mean((records.end_value <= 1) & np.isinf(records.lost_at))),
    }


def first_words(row: dict[str, Any]) -> str:
    """Return the first bound exceeded, how often and where, from a row of ``beyond_row``."""
    if row["first"] is None:
        return "nothing"
    low, high = row["first_winds"]
    return f"{row['first']}, {100 * row['first_runs']:.1f} % ({low:.1f} to {high:.1f} m/s)"


def sentence(campaign: Campaign) -> str:
    """Return a one-line summary of a campaign inside the certified class."""
    runs, seconds = campaign.runs, campaign.duration
    hours = runs * seconds / 3600
    what = f"{runs} runs of {seconds:g} s ({hours:.0f} h of operation)"
    if campaign.violations:
        return f"{what}: {campaign.violations} violate a certified bound"
    if campaign.coarse:
        return f"{what}: no violation, but steps half as long differ by more than the tolerance"
    return f"{what}: no violation of any certified bound"


def as_json(
    inside: Campaign | None, beyond: Sequence[Campaign], about: dict[str, Any], files: Sequence[str]
) -> str:
    """Return all results as JSON; the same campaigns give the same text.

    Parameters
    ----------
    about : what was simulated: file, verdict.
    """
    content: dict[str, Any] = {**about, "inside": None, "beyond": [], "files": list(files)}
    if inside is not None:
        content["inside"] = {
            **_setting(inside),
            "violations": inside.violations,
            "bounds": bound_rows(inside),
            "winds": player_rows(inside),
        }
    for campaign in beyond:
        content["beyond"].append(
            {
                **_setting(campaign),
                **beyond_row(campaign),
                "breaks": [
                    {
                        "bound": b.bound,
                        "runs": b.runs,
                        "first": b.first,
                        "earliest": b.earliest,
                        "winds": list(b.wind),
                    }
                    for b in breaks_of(campaign)
                ],
            }
        )
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def as_csv(campaigns: Sequence[Campaign]) -> str:
    """Return one line per run: its start, its ratios, the bounds exceeded and when."""
    head = (
        *("campaign", "winds", "start wind [m/s]", "start V [-]", "inertia [-]"),
        *(f"largest share of {name} [-]" for name in BOUNDS),
        *("end V [-]", "set left after [s]", "table left after [s]"),
    )
    return csv_text(head, (_run_cells(c, n) for c in campaigns for n in range(c.runs)))


def _run_cells(campaign: Campaign, n: int) -> tuple[str, ...]:
    r = campaign.records
    return (
        campaign.beyond.name,
        tuple(PLAYERS)[r.player[n]],
        *(f"{x:.6g}" for x in (r.start_wind[n], r.start_value[n], 1 / r.kappa[n])),
        *(_short(x) for x in r.share[:, n]),
        f"{r.end_value[n]:.6g}",
        _short(r.broken_at[0, n]),
        _short(r.lost_at[n]),
    )


def _setting(campaign: Campaign) -> dict[str, Any]:
    return {
        "runs": campaign.runs,
        "duration": campaign.duration,
        "step": campaign.step,
        "seed": campaign.seed,
        "tolerance": campaign.tolerance,
        "units": "SI; overspeed in %",
        "outside": campaign.beyond != INSIDE,
    }


def _largest(row: Any) -> float | None:
    kept = row[~np.isnan(row)]
    return _number(float(kept.max())) if len(kept) else None


def _number(value: float) -> float | None:
    """Return a number that JSON can represent; None for nan or infinity."""
    return value if math.isfinite(value) else None


def _short(value: float) -> str:
    return f"{value:.6g}" if math.isfinite(value) else ""
