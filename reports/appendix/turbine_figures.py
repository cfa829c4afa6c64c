"""The figures of a turbine's appendix."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.turbine.trim import TrimPoint, trim
from takagi.reports.appendix.robustness import TrimLoops
from takagi.reports.sections.turbine.blending import filter_of
from takagi.reports.sections.turbine.operation import power_surface, trim_drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BODE_WINDS = (6.0, 10.0, 11.4, 12.0, 14.0, 18.0, 25.0)
_CURVE = 120


def drawn_figures(design: TurbineDesign, loops: list[TrimLoops]) -> dict[str, Figure]:
    """Return name -> figure; a figure without content is left out."""
    drawn: dict[str, Callable[[], Figure | None]] = {
        "surface": lambda: _surface(design),
        "trim": lambda: _trim(design),
        "memberships": lambda: _memberships(design),
        "cells": lambda: _cells(design),
        "poles": lambda: _poles(design, loops),
        "bode-torque": lambda: _bode(loops, "torque"),
        "bode-pitch": lambda: _bode(loops, "pitch"),
    }
    figures = {name: draw() for name, draw in drawn.items()}
    return {name: figure for name, figure in figures.items() if figure is not None}


def _surface(design: TurbineDesign) -> Figure:
    turbine = design.turbine
    ratio = np.linspace(*turbine.power.x_range, 90)
    pitch = np.linspace(*turbine.power.y_range, 80)
    return power_surface(design, _curve(design), ratio=ratio, pitch=pitch)


def _trim(design: TurbineDesign) -> Figure:
    points = _curve(design)
    begins: dict[str, float] = {}
    for point in points:
        begins.setdefault(point.region, point.wind)
    return trim_drawing(design, points, begins)


def _curve(design: TurbineDesign) -> list[TrimPoint]:
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    winds = np.linspace(turbine.cut_in, turbine.cut_out, _CURVE)
    return [trim(turbine, float(v), speed_setpoint=setpoint) for v in winds]


def _memberships(design: TurbineDesign) -> Figure:
    from takagi.reports.figures import membership_figure

    coupling = filter_of(design)
    middle, width = coupling.speed_ramp.start, coupling.speed_ramp.width
    speed = np.linspace(middle - 2 * width, middle + 3 * width, 121)
    window = 4 * coupling.torque_overlap
    torque = np.linspace(
        coupling.minimum_torque - window, max(coupling.top_torque, coupling.rated_torque), 121
    )
    return membership_figure(speed, torque, coupling.memberships(speed[None, :], torque[:, None]))


def _cells(design: TurbineDesign) -> Figure | None:
    """Return the figure of the proved rates over wind; None if the claim is not proved."""
    from takagi.reports.figures import cells_figure

    law, found = design.effort_sharing_law, design.candidate
    if law is None or found is None or found.P is None:
        return None
    if design.checked.verdict is not Verdict.PROVED:
        return None
    peak = float(np.sqrt(np.linalg.inv(found.P)[0, 0])) / design.turbine.rated_rotor_speed
    return cells_figure(
        law.schedule.wind,
        np.ones(len(found.cells), dtype=bool),
        decay_rate=found.decay_rate,
        wind_rate=found.wind_rate,
        overspeed=np.full(len(found.cells), peak),
    )


def _poles(design: TurbineDesign, loops: list[TrimLoops]) -> Figure | None:
    from takagi.reports.figures import poles_figure

    if not loops:
        return None
    return poles_figure([item.wind for item in loops], [item.loops.poles for item in loops])


def _bode(loops: list[TrimLoops], channel: str) -> Figure | None:
    from takagi.reports.figures import BodeLine, bode_figure
    from takagi.reports.margins import loop_margins, loop_response

    omega = np.geomspace(3e-3, 30, 900)
    lines = []
    for item in loops:
        acts = item.at.torque_acts if channel == "torque" else item.at.pitch_acts
        if not acts or item.wind not in _BODE_WINDS:
            continue
        loop = item.loops.torque if channel == "torque" else item.loops.pitch
        margins = loop_margins(loop)
        # The phase at the crossover of an unstable loop is not a margin, and is not marked.
        shown = margins.stable is not False and np.isfinite(margins.phase_frequency)
        lines.append(
            BodeLine(
                f"{item.wind:g} m/s" + (" (unstable)" if margins.stable is False else ""),
                loop_response(loop).evaluate(omega)[:, 0, 0],
                crossover=margins.phase_frequency if shown else None,
            )
        )
    return bode_figure(omega, lines) if lines else None
