"""The verdict first: what is proved, in words and numbers, and what is left out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from takagi.reports.claim_summary import ClaimSummary, claim_summary
from takagi.reports.html.drawings import wind_class_figure
from takagi.reports.html.text import Section, at_least, at_most, fixed, plate, span

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import TurbineDesign

__all__ = ["verdict_section"]

RPM = 30 / math.pi

ALTERNATIVE = (
    "Two step curves over wind: the largest difference between wind and schedule wind, and the "
    "largest rate of the schedule wind, for which the set is proved invariant"
)


def verdict_section(design: TurbineDesign) -> Section:
    """Return the verdict box of a design."""
    summary = claim_summary(design)
    content: dict[str, Any] = {
        "verdict": design.checked.verdict.name,
        "meaning": design.checked.verdict.value,
        "claims": [(c.name, c.verdict.name, c.text) for c in design.checked.claims],
        "law": design.law.name,
        "turbine": design.turbine.name,
        "summary": summary,
        "setpoint": design.settings.speed_setpoint,
    }
    if summary is not None:
        content |= {
            "facts": _facts(design, summary),
            "unproved": [
                f"{low:g} to {high:g} m/s"
                for (low, high), fine in zip(summary.winds, summary.proved, strict=True)
                if not fine
            ],
            "figure": plate(
                wind_class_figure(summary),
                "wind-class",
                caption="The certified wind class over the schedule wind v<sub>s</sub> that the "
                "law works with. Wind that stays below both curves cannot drive the loop out of "
                "the invariant set. Hatched: not proved.",
                alternative=ALTERNATIVE,
            ),
        }
    return Section("verdict", "Verdict", content)


def _facts(design: TurbineDesign, summary: ClaimSummary) -> list[tuple[str, str, str]]:
    """Return (what, figure, remark) of the claim."""
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
            f"|v \u2212 v<sub>s</sub>| up to {span(summary.wind_error)} m/s",
            f"and |v<sub>s</sub>'| up to {span(summary.wind_rate)} m/s², depending on the wind "
            "(figure)",
        ),
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
        *_actuators(design),
        (
            "Uncertainty",
            f"inertia {fixed(100 * low, 0)} to {fixed(100 * high, 0)} %",
            "pitch effectiveness anywhere between the table's and the frozen wake's"
            if summary.frozen_wake
            else "pitch effectiveness as in the table",
        ),
    ]
    return facts


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
            f"{fixed(turbine.rated_torque / 1e3, 2)} kN m",
        ),
        (
            "Pitch",
            f"{fixed(math.degrees(turbine.pitch_min), 1)} to {at_most(max(pitch), 1)}°",
            f"inside its limits, {fixed(math.degrees(turbine.pitch_min), 0)} to "
            f"{fixed(math.degrees(turbine.pitch_max), 0)}°",
        ),
        (
            "Pitch rate",
            f"\u2264 {at_most(min(rate, limit), 1)} °/s",
            f"up to {at_most(rate, 1)} °/s is demanded; limit {fixed(limit, 1)} °/s: {part}",
        ),
    ]
