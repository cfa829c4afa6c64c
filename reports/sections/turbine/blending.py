"""Blending of torque and pitch: h^a(omega, T_g) of the coupling filter, and the effort ramp."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.laws.published.coupling_filter import CouplingFilter, coupling_filter
from takagi.models.laws.published.law import PublishedLaw
from takagi.reports.figures import membership_figure
from takagi.reports.figures.captioned_figure import captioned_figure
from takagi.reports.page.text import CaptionedFigure, Section, significant, with_decimals
from takagi.reports.sections.turbine.drawings import effort_figure
from takagi.reports.sections.turbine.operation import trim_curve

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

GRID = (121, 101)


def blending_section(design: TurbineDesign) -> Section:
    """Return the section about the blending of torque and pitch control."""
    coupling = filter_of(design)
    content: dict[str, Any] = {
        "coherent": design.effort_sharing_law is not None,
        "coupling": coupling,
        "speed_overlap": significant(coupling.speed_ramp.width),
        "torque_overlap": with_decimals(coupling.torque_overlap / 1e3, 2),
        "corners": [(with_decimals(a, 3), with_decimals(b, 0)) for a, b in _corners(coupling)],
        "memberships": _memberships(design, coupling),
    }
    if design.effort_sharing_law is not None:
        overlap = float(design.effort_sharing_law.schedule.overlap)
        content["overlap"] = significant(overlap)
        content["effort"] = captioned_figure(
            effort_figure(overlap),
            "effort-ramp",
            caption="The effort ramp and its slope, the share of pitch in a change of effort. "
            "The shares sum to 1 at every effort; both act in the shaded overlap only.",
            alternative="The ramp psi of the demanded effort and of its negative, and their "
            "slopes, which sum to one",
        )
    return Section("blending", "Blending of torque and pitch", content)


def filter_of(design: TurbineDesign) -> CouplingFilter:
    """Return the filter of a published law; for another law the filter of its settings."""
    if isinstance(design.law, PublishedLaw):
        return design.law.coupling
    asked = design.settings
    return coupling_filter(
        design.turbine,
        speed_overlap=asked.speed_overlap,
        torque_overlap=asked.torque_overlap,
        speed_setpoint=asked.speed_setpoint,
    )


def _corners(coupling: CouplingFilter) -> list[tuple[float, float]]:
    return [(float(matrix[0, 0]), float(matrix[1, 1])) for matrix in coupling.corners]


def _memberships(design: TurbineDesign, coupling: CouplingFilter) -> CaptionedFigure:
    ramp, turbine = coupling.speed_ramp, design.turbine
    margin = max(0.15, 1.5 * ramp.width)
    speed = np.linspace(ramp.start - margin, ramp.end + margin, GRID[0])
    low = turbine.rated_torque - max(6 * coupling.torque_overlap, 0.2 * turbine.rated_torque)
    torque = np.linspace(low, coupling.top_torque, GRID[1])
    points = trim_curve(design, step=0.25)
    inside = [p for p in points if speed[0] <= p.rotor_speed and low <= p.torque]
    path = ([p.rotor_speed for p in inside], [p.torque for p in inside])
    titles = [
        f"$h^a_{m}$: $f_2$ = {f2:.3f}, $f_1$ = {f1:.0f}"
        for m, (f2, f1) in enumerate(_corners(coupling), 1)
    ]
    figure = membership_figure(
        speed,
        torque,
        coupling.memberships(speed[None, :], torque[:, None]),
        titles=titles,
        path=path if inside else None,
    )
    return captioned_figure(
        figure,
        "memberships",
        caption="Memberships h<sup>a</sup><sub>m</sub>(ω, T<sub>g</sub>) of the coupling "
        "filter's four corners, T<sub>g</sub> the commanded torque. Black line: the turbine's "
        "trim.",
        alternative="Four contour panels of the coupling filter's memberships over rotor speed "
        "and commanded torque, with the trim curve",
    )
