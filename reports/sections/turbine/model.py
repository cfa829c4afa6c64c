"""The turbine and its regional models: parameters, surface, steady operation, wind observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.design.turbine.result import ClaimSummary, TurbineDesign
from takagi.lmi.turbine.regional import RegionGains
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.laws.published.regional_schedule import CouplingFilter, coupling_filter
from takagi.models.ramps import effort_ramp, effort_ramp_slope
from takagi.models.ts.model import TSModel
from takagi.models.turbine.trim import TrimPoint, optimal_tip_speed_ratio, rated_wind, trim
from takagi.reports.figures.operation import (
    cells_figure,
    membership_figure,
    power_surface_figure,
    trim_figure,
)
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    captioned_figure,
    decimate,
    house_style,
    new_figure,
    region_axes,
)
from takagi.reports.loops.plant_claims import synthesis_words
from takagi.reports.page.assembly import premise_table
from takagi.reports.page.text import (
    CaptionedFigure,
    Section,
    Table,
    lower_bound,
    significant,
    table,
    upper_bound,
    with_decimals,
)
from takagi.reports.simulation.measured_loop import DesignRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure


RPM, DEGREES = 30 / np.pi, 180 / np.pi
GRID = (90, 90)
LARGEST_SHOWN_PITCH = np.radians(30)


def model_section(design: TurbineDesign) -> Section:
    """Return the section about the plant."""
    turbine = design.turbine
    points, starts = trim_curve(design), region_starts(design)
    figures = ((key, f"{f.value:.10g}", f.unit, f.source) for key, f in turbine.figures.items())
    return Section(
        "model",
        "The turbine",
        {
            "turbine": turbine,
            "inertia": f"{turbine.inertia:,.0f}".replace(",", "\u202f"),
            "frequency": float(np.sqrt(turbine.tower_stiffness / turbine.tower_mass) / 2 / np.pi),
            "starts": {k: with_decimals(v, 2) for k, v in starts.items()},
            "figures_table": table("figures", figures),
            "surface": _surface(design, points),
            "curves": captioned_figure(trim_figure(design, points, starts), "trim"),
        },
    )


def _surface(design: TurbineDesign, points: tuple[TrimPoint, ...]) -> CaptionedFigure:
    turbine = design.turbine
    low, high = turbine.power.x_range
    largest_pitch = min(turbine.power.y_range[1], LARGEST_SHOWN_PITCH)
    ratio = np.linspace(low, high, GRID[0])
    pitch = np.linspace(max(turbine.power.y_range[0], turbine.pitch_min), largest_pitch, GRID[1])
    band = None
    if design.effort_sharing_law is None:
        band = float(dict(design.full_load.box)["pitch deviation [rad]"][1])
    return captioned_figure(
        power_surface_figure(turbine, points, ratio=ratio, pitch=pitch, band=band),
        "power-coefficient",
        "surface",
        band=" and the band in pitch on which the full-load model is exact" if band else "",
    )


def region_starts(design: TurbineDesign) -> dict[str, float]:
    """Return region -> wind at which it begins [m/s], for winds between cut-in and cut-out."""
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    per_speed = turbine.rotor_radius / optimal_tip_speed_ratio(turbine)
    starts = {
        "2": turbine.minimum_rotor_speed * per_speed,
        "2.5": (setpoint or turbine.rated_rotor_speed) * per_speed,
        "3": rated_wind(turbine, speed_setpoint=setpoint),
    }
    inside = {k: v for k, v in starts.items() if turbine.cut_in < v < turbine.cut_out}
    return inside


def trim_curve(design: TurbineDesign, *, step: float = 0.1) -> tuple[TrimPoint, ...]:
    """Return the turbine's trim from cut-in to cut-out; the winds include the regions' ends."""
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    count = int(round((turbine.cut_out - turbine.cut_in) / step)) + 1
    winds = np.linspace(turbine.cut_in, turbine.cut_out, count)
    every = np.union1d(winds, list(region_starts(design).values()))
    return tuple(trim(turbine, float(v), speed_setpoint=setpoint) for v in every)


CORNERS = ("lower", "upper")
EVIDENCE = "why it cannot leave"
SYMBOLS = {"partial load": ("k<sub>ω</sub>",), "full load": ("k<sub>ω</sub>", "k<sub>β</sub>")}
UNITS = {"partial load": ("N m s/rad", "N m/rad"), "full load": ("s", "-", "1/rad")}


def regions_section(design: TurbineDesign) -> Section:
    """Return the section about the regional models and their gains."""
    regions = (design.regional.partial, design.regional.full)
    return Section(
        "regions",
        "Regional Takagi–Sugeno models",
        {"regions": [_region(region) for region in regions]},
    )


def _region(region: RegionGains) -> dict[str, Any]:
    return {
        "result": region,
        "premises": premise_table(region.model, f"Premises, {region.region}", EVIDENCE),
        "vertices": _vertices(region.model),
        "gains": _gains(region),
    }


def _vertices(model: TSModel) -> list[dict[str, Any]]:
    """Return one entry for each rule: its corners, and its matrices as rows of text."""
    entries = []
    for number, (rule, vertex) in enumerate(zip(model.rules, model.vertices, strict=True), 1):
        corners = [f"{p.name} {CORNERS[c]}" for p, c in zip(model.premises, rule, strict=True)]
        matrices = [
            (name, [[significant(float(x), 5) for x in row] for row in getattr(vertex, name)])
            for name in ("A", "B", "E")
            if getattr(vertex, name).size
        ]
        entries.append({"number": number, "corners": ", ".join(corners), "matrices": matrices})
    return entries


def _gains(region: RegionGains) -> Table | None:
    if region.k_x is None or region.k_I is None:
        return None
    names = [p.name for p in region.model.premises]
    heads = [*SYMBOLS[region.region], "k<sub>I</sub>"]
    return Table(
        f"Gains, {region.region}: u = −k<sub>x</sub> Δx + k<sub>I</sub> x<sub>I</sub>",
        (
            ("rule", ""),
            *((name, "") for name in names),
            *zip(heads, UNITS[region.region], strict=True),
        ),
        tuple(
            (
                str(k + 1),
                *(CORNERS[c] for c in rule),
                *(significant(float(x), 6) for x in region.k_x[k]),
                significant(float(region.k_I[k]), 6),
            )
            for k, rule in enumerate(region.model.rules)
        ),
    )


def observer_section(design: TurbineDesign) -> Section:
    """Return the section about the wind observer."""
    premises = premise_table(design.observer.model, "Premises, estimation error", EVIDENCE)
    return Section("observer", "Wind observer", {"observer": design.observer, "premises": premises})


# The gust's picture ends here [s].
SHOWN = 60.0


def gust_figure(run: DesignRun, bound: float | None, inside: NDArray[np.bool_] | None) -> Figure:
    """Return wind and rotor speed over time [s], and the proved bound [rad/s] where it holds.

    ``inside`` says where that is, (n,); None without proved wind limits.
    """
    time, rpm, law = run.time, 30 / np.pi, run.law.line
    assert law is not None  # the gust is drawn
    inside = np.ones(len(time), bool) if inside is None else inside
    edges = np.flatnonzero(np.diff(inside.astype(int))) + 1
    spans = np.split(np.arange(len(time)), edges)
    with house_style():
        figure, (wind, speed) = new_figure(2, 1, width=4.6, height=3.4, share_x=True)
        wind.plot(*decimate(time, law.wind), color="#333333", label="wind")
        wind.plot(*decimate(time, run.schedule), color=COLOURS[2], ls=":", label="schedule wind")
        wind.set_ylabel("wind [m/s]")
        speed.plot(*decimate(time, rpm * law.rotor_speed), color=COLOURS[0], label="this law")
        if run.reference is not None and run.reference.line is not None:
            reference_speed = rpm * run.reference.line.rotor_speed
            label = "reference controller"
            speed.plot(*decimate(time, reference_speed), color=COLOURS[1], ls="--", label=label)
        label = "proved bound"
        for span in spans:
            ends = time[span[0]], time[span[-1]]
            if not inside[span[0]]:
                for axes in (wind, speed):
                    axes.axvspan(*ends, color=GREY, alpha=0.18, linewidth=0.0)
            elif bound is not None:
                speed.plot(ends, [rpm * bound] * 2, color="black", lw=2.5, label=label)
                label = "_nolegend_"
        speed.set_ylabel("rotor speed [rpm]")
        speed.set_xlabel("time [s]")
        speed.set_xlim(0.0, min(SHOWN, float(time[-1])))
        handles = [*wind.get_legend_handles_labels()[0], *speed.get_legend_handles_labels()[0]]
        spaced = {"ncols": 3, "handlelength": 1.5, "columnspacing": 1.0}
        figure.legend(handles=handles, loc="outside lower center", **spaced)
    return figure


def gains_figure(law: EffortSharingLaw, regions: dict[str, float]) -> Figure:
    """Return gamma, nu, b with its limit, and the share of pitch over the schedule wind."""
    table, wind = law.schedule, law.schedule.wind
    fine = np.linspace(wind[0], wind[-1], 800)
    share = effort_ramp_slope(np.interp(fine, wind, table.trim_effort), table.overlap)
    with house_style():
        figure, panels = new_figure(2, 2, height=4.8, share_x=True)
        panels[0].plot(wind, law.gains.proportional, color=COLOURS[0])
        panels[0].set_ylabel("proportional \u03b3 [1/s]")
        panels[1].stairs(law.gains.integral_rate, wind, baseline=None, color=COLOURS[0], lw=1.5)
        panels[1].set_ylabel("integral rate \u03bd [1/s]")
        panels[2].plot(wind, table.effectiveness, color=COLOURS[0], label="assumed, b")
        panels[2].plot(
            wind, table.effectiveness_limit, color=COLOURS[1], ls="--", label="frozen wake"
        )
        panels[2].set_ylabel("pitch effectiveness\n[rad/s\u00b2 per rad]")
        panels[2].legend(loc="upper left")
        panels[3].plot(fine, share, color=COLOURS[0], label="pitch, F")
        panels[3].plot(fine, 1 - share, color=COLOURS[1], ls="--", label="torque, 1 \u2212 F")
        panels[3].set_ylabel("share at the trim [-]")
        panels[3].legend(loc="center right")
        for axes in panels:
            axes.set_ylim(bottom=0.0)
        region_axes(panels, wind, regions)
    return figure


def effort_figure(overlap: float) -> Figure:
    """Return psi(U) and psi(-U) [rad/s^2], and the shares psi' and 1 - psi', over the effort."""
    effort = np.linspace(-4 * overlap, 4 * overlap, 401)
    share = effort_ramp_slope(effort, overlap)
    with house_style():
        figure, (ramp, shares) = new_figure(1, 2, height=3.2)
        ramp.plot(effort, effort_ramp(effort, overlap), color=COLOURS[0], label="pitch, \u03c8(U)")
        ramp.plot(
            effort,
            effort_ramp(-effort, overlap),
            color=COLOURS[1],
            ls="--",
            label="torque reserve, \u03c8(\u2212U)",
        )
        ramp.set_ylabel("effort delivered [rad/s\u00b2]")
        shares.plot(effort, share, color=COLOURS[0], label="pitch, F = \u03c8'(U)")
        shares.plot(effort, 1 - share, color=COLOURS[1], ls="--", label="torque, 1 \u2212 F")
        shares.set_ylabel("share of a change of effort [-]")
        for axes in (ramp, shares):
            axes.set_xlabel("demanded effort U [rad/s\u00b2]")
            axes.axvspan(-overlap, overlap, color=GREY, alpha=0.12, lw=0)
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.2))
    return figure


def cells_section(design: TurbineDesign, summary: ClaimSummary) -> Section:
    """Return the section with the details of the claim about the set, cell by cell."""
    content = {
        "figure": captioned_figure(
            cells_drawing(design, summary), "cells", hatched=summary.hatched
        ),
        "P": [[with_decimals(value, 4) for value in row] for row in summary.P],
        "peaks": [(name.replace("_", " "), upper_bound(v, 4)) for name, v in summary.peaks.items()],
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
                lower_bound(summary.decay_rates[k]),
                lower_bound(summary.wind_error[k]),
                lower_bound(summary.wind_rate[k]),
                upper_bound(100 * over[k], 2),
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
