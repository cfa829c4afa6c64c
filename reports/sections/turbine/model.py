"""The turbine and its regional models: parameters, surface, steady operation, wind observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.turbine.trim import TrimPoint, optimal_tip_speed_ratio, rated_wind, trim
from takagi.reports.figures.operation import power_surface_figure, trim_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.page.text import (
    CaptionedFigure,
    Section,
    Table,
    significant,
    table,
    with_decimals,
)
from takagi.reports.sections.shared import premise_table

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.lmi.turbine.regional import RegionGains
    from takagi.models.ts.model import TSModel

RPM, DEGREES = 30 / np.pi, 180 / np.pi
GRID = (90, 90)
LARGEST_SHOWN_PITCH = np.radians(30)


def model_section(design: TurbineDesign) -> Section:
    """Return the section about the plant."""
    turbine = design.turbine
    points = trim_curve(design)
    return Section(
        "model",
        "The turbine",
        {
            "turbine": turbine,
            "inertia": f"{turbine.inertia:,.0f}".replace(",", "\u202f"),
            "frequency": float(np.sqrt(turbine.tower_stiffness / turbine.tower_mass) / 2 / np.pi),
            "starts": {k: with_decimals(v, 2) for k, v in region_starts(design).items()},
            "figures_table": _figures(design),
            "surface": _surface(design, points),
            "curves": _curves(design, points),
        },
    )


def _figures(design: TurbineDesign) -> Table:
    figures = design.turbine.figures
    rows = ((key, f"{f.value:.10g}", f.unit, f.source) for key, f in figures.items())
    return table("figures", rows)


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


def _curves(design: TurbineDesign, points: tuple[TrimPoint, ...]) -> CaptionedFigure:
    return captioned_figure(trim_figure(design, points, region_starts(design)), "trim")


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
