"""The certificate cell by cell."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from takagi.certificates.design.turbine.result import ClaimSummary, claim_summary
from takagi.reports.figures import cells_figure
from takagi.reports.figures.captioned_figure import captioned_figure
from takagi.reports.page.text import Section, Table, at_least, at_most, with_decimals

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign


def cells_section(design: TurbineDesign) -> Section:
    """Return the section with the details of the verdict."""
    summary = claim_summary(design)
    content: dict[str, Any] = {
        "summary": summary,
        "claims": [(c.name, c.verdict.name, c.text) for c in design.checked.claims],
    }
    if summary is not None:
        content |= _details(design, summary)
    return Section("certificate", "The certificate, cell by cell", content)


def _details(design: TurbineDesign, summary: ClaimSummary) -> dict[str, Any]:
    rated = design.turbine.rated_rotor_speed
    reference = design.document["gains"]["rotor_speed"]
    peak = summary.peaks["speed_error"]
    # Per cell: the faster end of the reference plus the bound on the speed error.
    over = [(max(a, b) + peak) / rated - 1 for a, b in zip(reference, reference[1:], strict=False)]
    figure = cells_figure(
        summary.edges,
        summary.proved,
        decay_rate=summary.decay_rates,
        wind_rate=summary.wind_rate,
        overspeed=[max(value, 0.0) for value in over],
    )
    return {
        "figure": captioned_figure(
            figure,
            "cells",
            caption="Per wind cell: proved decay rate at constant wind, largest rate of the "
            "schedule wind, and the bound on rotor speed above rated (0 where the bound lies "
            f"below rated speed).{summary.hatched}",
            alternative="Decay rate, wind class and overspeed bound per wind cell",
        ),
        "P": [[with_decimals(value, 4) for value in row] for row in summary.P],
        "peaks": [(name.replace("_", " "), at_most(v, 4)) for name, v in summary.peaks.items()],
        "table": _table(design, summary, over),
    }


def _table(design: TurbineDesign, summary: ClaimSummary, over: list[float]) -> Table:
    extra = _ranges(design, len(summary.winds))
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
                *extra[k],
            )
        )
    return Table(
        "Every wind cell",
        (
            ("schedule wind", "m/s"),
            ("proved", ""),
            ("decay", "1/s"),
            ("|v − v<sub>s</sub>|", "m/s"),
            ("|v<sub>s</sub>'|", "m/s²"),
            ("speed over rated", "%"),
            ("torque", "kN m"),
            ("pitch", "°"),
            ("pitch rate demanded", "°/s"),
        ),
        tuple(rows),
        folded=f"All {len(rows)} cells as a table",
    )


def _ranges(design: TurbineDesign, count: int) -> list[tuple[str, str, str]]:
    """Return torque, pitch and demanded pitch rate on the enclosed set of each cell."""
    if design.candidate is None:
        return [("", "", "")] * count
    rated, found = design.turbine.rated_torque, []
    for cell in design.candidate.cells:
        torque = [min(float(end), rated) / 1e3 for end in (cell.torque.lower, cell.torque.upper)]
        pitch = [math.degrees(float(end)) for end in (cell.pitch.lower, cell.pitch.upper)]
        found.append(
            (
                f"{with_decimals(torque[0], 2)} – {with_decimals(torque[1], 2)}",
                f"{with_decimals(pitch[0], 2)} – {with_decimals(pitch[1], 2)}",
                with_decimals(math.degrees(float(cell.pitch_rate)), 2),
            )
        )
    return found
