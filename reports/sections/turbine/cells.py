"""The gains over wind, the certificate cell by cell, and how torque and pitch are blended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.turbine.result import ClaimSummary
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.laws.published.regional_schedule import CouplingFilter, coupling_filter
from takagi.reports.figures.cells import cells_figure
from takagi.reports.figures.operation import membership_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.plant_claims import synthesis_words
from takagi.reports.page.text import Section, Table, at_least, at_most, table, with_decimals
from takagi.reports.sections.turbine.drawings import effort_figure, gains_figure
from takagi.reports.sections.turbine.model import region_starts, trim_curve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw


def cells_section(design: TurbineDesign, summary: ClaimSummary) -> Section:
    """Return the section with the details of the claim about the set, cell by cell."""
    content = {
        "figure": captioned_figure(
            cells_drawing(design, summary), "cells", hatched=summary.hatched
        ),
        "P": [[with_decimals(value, 4) for value in row] for row in summary.P],
        "peaks": [(name.replace("_", " "), at_most(v, 4)) for name, v in summary.peaks.items()],
        "table": _table(design, summary, over_rated(design, summary)),
    }
    return Section("certificate", "The proved set, cell by cell", content)


def cells_drawing(design: TurbineDesign, summary: ClaimSummary) -> Figure:
    """Return decay rate, wind limits and bound on the speed for each wind cell."""
    return cells_figure(
        summary.edges,
        summary.proved,
        decay_rate=summary.decay_rates,
        wind_error=summary.wind_error,
        wind_rate=summary.wind_rate,
        overspeed=[max(value, 0.0) for value in over_rated(design, summary)],
    )


def over_rated(design: TurbineDesign, summary: ClaimSummary) -> list[float]:
    """Return per cell the faster end of the reference plus the bound on the speed error."""
    rated, peak = design.turbine.rated_rotor_speed, summary.peaks["speed_error"]
    reference = design.document["gains"]["rotor_speed"]
    return [(max(a, b) + peak) / rated - 1 for a, b in zip(reference, reference[1:], strict=False)]


def _table(design: TurbineDesign, summary: ClaimSummary, over: list[float]) -> Table:
    rows = []
    for k, ((low, high), fine) in enumerate(zip(summary.winds, summary.proved, strict=True)):
        rows.append(
            (
                f"{low:g} – {high:g}",
                "yes" if fine else "no",
                at_least(summary.decay_rates[k]),
                at_least(summary.wind_error[k]),
                at_least(summary.wind_rate[k]),
                at_most(100 * over[k], 2),
            )
        )
    return table("cells", rows)


def blending_section(design: TurbineDesign) -> Section:
    """Return the section about the blending of torque and pitch control."""
    coupling = filter_of(design)
    content = {
        "coupling": coupling,
        "memberships": captioned_figure(
            memberships_drawing(design, coupling), "memberships", "filter"
        ),
    }
    return Section("blending", "Blending of torque and pitch", content)


def filter_of(design: TurbineDesign) -> CouplingFilter:
    """Return the filter of a published law; for another law the filter of its settings."""
    if isinstance(design.law, PublishedLaw):
        return design.law.coupling
    settings = design.settings
    return coupling_filter(
        design.turbine,
        speed_overlap=settings.speed_overlap,
        torque_overlap=settings.torque_overlap,
        speed_setpoint=settings.speed_setpoint,
    )


def memberships_drawing(design: TurbineDesign, coupling: CouplingFilter) -> Figure:
    """Return the memberships of the filter's four corners, with the trim."""
    return membership_figure(coupling, design.turbine, trim_curve(design, step=0.25))


def gains_section(design: TurbineDesign) -> Section:
    """Return the section about the law and its gains."""
    law = design.effort_sharing_law
    content: dict[str, Any] = {"law": design.law, "figure": None}
    if law is not None:
        content |= _effort_sharing(design, law)
    else:
        content["rules"] = [4, len(design.partial_load.rules), len(design.full_load.rules)]
    return Section("law", "The law and its gains", content)


def _effort_sharing(design: TurbineDesign, law: EffortSharingLaw) -> dict[str, Any]:
    limited = design.effort.torque_limited if design.effort is not None else np.zeros(0)
    winds = law.schedule.wind[limited.astype(bool)] if limited.size else limited
    return {
        "figure": captioned_figure(gains_figure(law, region_starts(design)), "gains"),
        "effort": captioned_figure(effort_figure(float(law.schedule.overlap)), "effort-ramp"),
        "synthesis": synthesis_words(design),
        "limited": "" if not winds.size else f"{winds.min():g} to {winds.max():g} m/s",
    }
