"""The verdict: the proved properties in words and numbers, and what is not covered."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import (
    ClaimSummary,
    claim_summary,
    running_loop_summary,
)
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.cells import OverlapRow, overlaps_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.overlap_claims import (
    OverlapClaim,
    gap_words,
    overlap_claims,
    wind_words,
    window_width,
)
from takagi.reports.loops.proved_kinds import proved_claims
from takagi.reports.page.text import (
    DASH,
    CaptionedFigure,
    Section,
    Table,
    at_least,
    at_most,
    decimal,
    range_text,
    with_decimals,
)
from takagi.reports.sections.shared import verdict_box
from takagi.reports.sections.turbine.drawings import wind_class_figure

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

RPM = 30 / math.pi

ALTERNATIVE = (
    "Two step curves over wind: the largest difference between wind and schedule wind, and the "
    "largest rate of the schedule wind, for which the set is proved invariant"
)


def verdict_section(design: TurbineDesign) -> Section:
    """Return the verdict box of a design."""
    summary, overlaps = claim_summary(design), overlap_claims(design)
    short = {claim.name for claim in overlaps}
    content: dict[str, Any] = {
        "assumes": "; ".join(design.checked.assumes),
        "claims": [
            (c.name, c.verdict.name, c.text) for c in design.checked.claims if c.name not in short
        ],
        "overlaps": overlaps,
        "law": law_words(design.law.name),
        "turbine": design.turbine.name,
        "summary": summary,
        "setpoint": design.settings.speed_setpoint,
    }
    if overlaps:
        content |= {
            "overlap_words": [(c.name, c.verdict.name, c.text) for c in overlaps],
            "overlap_figure": _overlap_figure(design, overlaps),
            "overlap_table": _overlap_table(overlaps),
            "overlap_gaps": [(c.label, gap_words(c)) for c in overlaps if _open(c)],
        }
    if summary is not None:
        content |= {
            "facts": _facts(design, summary),
            "unproved": [
                f"{low:g} to {high:g} m/s"
                for (low, high), fine in zip(summary.winds, summary.proved, strict=True)
                if not fine
            ],
            "figure": captioned_figure(
                wind_class_figure(summary),
                "wind-class",
                caption="The certified wind class over the schedule wind v<sub>s</sub> that the "
                "law works with. Wind that stays below both curves cannot drive the loop out of "
                f"the invariant set.{summary.hatched}",
                alternative=ALTERNATIVE,
            ),
        }
    return verdict_box(design.checked, content)


def _open(claim: OverlapClaim) -> bool:
    """Return whether a claim is not proved, or that of the chosen overlaps leaves winds out."""
    return claim.verdict is not Verdict.PROVED or (claim.chosen and bool(claim.left))


def _overlap_figure(design: TurbineDesign, claims: tuple[OverlapClaim, ...]) -> CaptionedFigure:
    turbine = design.turbine
    rows = [
        OverlapRow(f"{c.label}{' (chosen)' if c.chosen else ''}", c.proved, c.left) for c in claims
    ]
    told = "; ".join(f"{claim.label}: {wind_words(claim)}" for claim in claims)
    return captioned_figure(
        overlaps_figure(rows, wind=(turbine.cut_in, turbine.cut_out)),
        "overlaps",
        caption="Winds for which each claim is proved, by overlap in speed and in torque. "
        "Filled: proved. Hatched: looked at, not proved. Blank: not looked at. Low bars are "
        "windows drawn wider than they are; their width is below the table.",
        alternative=f"One bar per pair of overlaps over wind. Proved winds: {told}",
    )


def _overlap_table(claims: tuple[OverlapClaim, ...]) -> Table:
    width = max(map(window_width, claims))
    windows = f", in windows of {width:g} m/s where so called" if width else ""
    return Table(
        "The claims by pair of overlaps",
        (
            ("overlaps", ""),
            ("verdict", ""),
            ("proved winds", ""),
            ("decay rate ≥", "1/s"),
            ("speed error ≤", "% of rated"),
            ("half-width ≤", "rad/s"),
        ),
        tuple(
            (
                f"{claim.label}{' (chosen)' if claim.chosen else ''}",
                claim.verdict.name,
                wind_words(claim),
                " to ".join(claim.decay) or DASH,
                claim.speed_share or DASH,
                claim.half_width or DASH,
            )
            for claim in claims
        ),
        note="A verdict is about the winds that its claim names; the bounds hold for the proved "
        f"winds{windows}. Decay rate: least and greatest over the cells. Speed error: of the "
        "equilibrium, from the reference speed. Half-width: of the widest set, in rotor speed.",
    )


def _facts(design: TurbineDesign, summary: ClaimSummary) -> list[tuple[str, str, str]]:
    """Return (name, figure, remark) of each fact about the claim."""
    turbine = design.turbine
    low, high = summary.inertia
    speed = (1 + summary.overspeed) * turbine.rated_rotor_speed * RPM
    slowest = summary.winds[summary.decay_rates.index(summary.decay_rate)]
    facts = [
        (
            "Winds",
            f"{summary.edges[0]:g} to {summary.edges[-1]:g} m/s",
            f"in {len(summary.winds)} cells without gaps, one quadratic function for all",
        ),
        (
            "Wind class",
            f"|v \u2212 v<sub>s</sub>| up to {range_text(summary.wind_error)} m/s",
            f"and |v<sub>s</sub>'| up to {range_text(summary.wind_rate)} m/s², depending on the "
            "wind (figure)",
        ),
        *_wind_rate(design),
        (
            "Decay",
            f"\u2265 {at_least(summary.common_rate)} 1/s",
            f"at a constant wind that the law knows, in one function for all winds; in the set's "
            f"own function from {at_least(summary.decay_rate)} 1/s ({slowest[0]:g} to "
            f"{slowest[1]:g} m/s) to {at_least(max(summary.decay_rates))} 1/s",
        ),
        (
            "Rotor speed",
            f"\u2264 {at_most(100 * summary.overspeed, 2)} % above rated",
            f"{at_most(speed, 2)} rpm; everywhere within "
            f"{at_most(summary.peaks['speed_error'] * RPM, 2)} rpm of the reference speed",
        ),
        *_with_observer(design),
        *_actuators(design),
        (
            "Uncertainty",
            f"inertia {decimal(100 * low)} to {decimal(100 * high)} %{_power(summary)}",
            "pitch effectiveness anywhere between the table's and the frozen wake's"
            if summary.frozen_wake
            else "pitch effectiveness as in the table",
        ),
    ]
    return facts


def _wind_rate(design: TurbineDesign) -> list[tuple[str, str, str]]:
    """Return the allowed rate of a known wind, where a claim about it is proved."""
    filter_ = float(design.document["gains"].get("wind_filter", 0))
    return [
        (
            "Wind's own rate",
            "|v'| up to "
            f"{range_text([float(r) for r in stated['ranges'][0]['estimate_rate']])} m/s²",
            f"of a wind that is known, through the law's filter of {filter_:g} s, "
            "depending on the wind",
        )
        for stated in proved_claims(design.document, design.checked, "wind-rate")[:1]
    ]


def _power(summary: ClaimSummary) -> str:
    """Return the covered power coefficients relative to the table; empty if it is only 1."""
    low, high = summary.power_coefficient
    if low == high:
        return ""
    return f", power coefficient {decimal(100 * low)} to {decimal(100 * high)} %"


def _with_observer(design: TurbineDesign) -> list[tuple[str, str, str]]:
    """Return what is proved of the loop with its observer, where a claim about it is proved."""
    found = running_loop_summary(design)
    if found is None:
        return []
    rate, winds = found
    where = f"at a constant wind, {winds}, from a set of each wind cell, with its filters, "
    where += "schedule wind within the tables"
    return [("Decay with the observer", f"\u2265 {at_least(rate)} 1/s", where)]


def _actuators(design: TurbineDesign) -> list[tuple[str, str, str]]:
    turbine = design.turbine
    if design.candidate is None:
        return []
    cells = design.candidate.cells
    least = min(float(cell.torque.lower) for cell in cells)
    pitch = [math.degrees(float(cell.pitch.upper)) for cell in cells]
    rate = max(math.degrees(float(cell.pitch_rate)) for cell in cells)
    limit = math.degrees(turbine.pitch_rate_limit)
    part = "saturation is part of the proof" if rate > limit else "the limit is never met"
    return [
        (
            "Torque",
            f"{at_least(least / 1e3, 2)} kN m to rated",
            f"commanded on the enclosed set: never negative, never above "
            f"{with_decimals(turbine.rated_torque / 1e3, 2)} kN m",
        ),
        (
            "Pitch",
            f"{with_decimals(math.degrees(turbine.pitch_min), 1)} to {at_most(max(pitch), 1)}°",
            f"inside its limits, {with_decimals(math.degrees(turbine.pitch_min), 0)} to "
            f"{with_decimals(math.degrees(turbine.pitch_max), 0)}°",
        ),
        (
            "Pitch rate",
            f"\u2264 {at_most(min(rate, limit), 1)} °/s",
            f"up to {at_most(rate, 1)} °/s is demanded; limit "
            f"{with_decimals(limit, 1)} °/s: {part}",
        ),
    ]
