"""The plant: its figures with sources, equations, power coefficient and trim."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.turbine.trim import TrimPoint
from takagi.reports.figures.captioned_figure import captioned_figure
from takagi.reports.page.text import CaptionedFigure, Section, Table, with_decimals
from takagi.reports.sections.turbine.operation import (
    power_surface,
    region_starts,
    trim_curve,
    trim_drawing,
)

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

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
            "trim_table": _trim_table(points),
            "figures_table": _figures(design),
            "surface": _surface(design, points),
            "curves": _curves(design, points),
        },
    )


def _figures(design: TurbineDesign) -> Table:
    return Table(
        "Figures of the turbine, as read from its file",
        (("figure", ""), ("value", ""), ("unit", ""), ("source", "")),
        tuple(
            (key, f"{item.value:.10g}", item.unit, item.source)
            for key, item in design.turbine.figures.items()
        ),
        folded="Every figure with its source",
    )


def _trim_table(points: tuple[TrimPoint, ...]) -> Table:
    shown = [p for p in points if abs(p.wind - round(p.wind)) < 1e-6]
    return Table(
        "Trim over wind",
        (
            ("wind", "m/s"),
            ("region", ""),
            ("rotor speed", "rpm"),
            ("pitch", "°"),
            ("torque", "kN m"),
        ),
        tuple(
            (
                with_decimals(p.wind, 0),
                p.region,
                with_decimals(p.rotor_speed * RPM, 3),
                with_decimals(p.pitch * DEGREES, 3),
                with_decimals(p.torque / 1e3, 3),
            )
            for p in shown
        ),
        folded="The trim as a table",
    )


def _surface(design: TurbineDesign, points: tuple[TrimPoint, ...]) -> CaptionedFigure:
    turbine = design.turbine
    low, high = turbine.power.x_range
    most = min(turbine.power.y_range[1], LARGEST_SHOWN_PITCH)
    ratio = np.linspace(low, high, GRID[0])
    pitch = np.linspace(max(turbine.power.y_range[0], turbine.pitch_min), most, GRID[1])
    band = float(dict(design.full_load.box).get("pitch deviation [rad]", (0, 0))[1])
    return captioned_figure(
        power_surface(design, points, ratio=ratio, pitch=pitch, band=band or None),
        "power-coefficient",
        caption="Power coefficient of the table's spline, with the trim from cut-in to cut-out "
        "and the band in pitch on which the full-load model is exact.",
        alternative="Contours of the power coefficient over tip-speed ratio and pitch, with the "
        "trim curve: it climbs in pitch as the tip-speed ratio falls with wind",
    )


def _curves(design: TurbineDesign, points: tuple[TrimPoint, ...]) -> CaptionedFigure:
    return captioned_figure(
        trim_drawing(design, points, region_starts(design)),
        "trim",
        caption="Trim over wind; dotted lines: where regions begin. Dots: the trim pitch "
        "published with the reference turbine.",
        alternative="Rotor speed, pitch, torque and electrical power over wind: speed and torque "
        "rise to their rated values near rated wind, above it pitch rises to cut-out",
    )
