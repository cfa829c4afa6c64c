"""Closed-loop poles over wind; Bode plots of the law's own loops, for the appendix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from takagi.reports.figures.loops import BodeLine, bode_figure, bode_line
from takagi.reports.loops.turbine_local import LoopPoint
from takagi.reports.margins.margins import Margins, loop_margins
from takagi.reports.margins.response import loop_response
from takagi.reports.margins.turbine_loops import Loops, loops_at_trim

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.certificates.design.turbine.result import TurbineDesign

FREQUENCY = np.geomspace(1e-2, 30.0, 700)
Actuator = Literal["torque", "pitch"]
ACTUATORS: tuple[Actuator, ...] = ("torque", "pitch")


@dataclass(frozen=True, slots=True, eq=False)
class LoopRow:
    """One loop at one wind with one wake; the wake multiplies dT_r/dbeta by ``factor``."""

    loop: LoopPoint
    actuator: Actuator
    wake: str
    factor: float
    loops: Loops
    margins: Margins


def loop_rows(design: TurbineDesign, point: LoopPoint) -> list[LoopRow]:
    """Return the loops at one wind, broken at each actuator that acts, for each wake."""
    wakes = [("equilibrium", 1.0)]
    if np.isfinite(point.frozen_wake):
        wakes.append(("frozen", point.frozen_wake))
    rows = []
    for wake, factor in wakes:
        loops = loops_at_trim(design.turbine, point.point, point.controller, effectiveness=factor)
        for actuator in _acting(point):
            margins = loop_margins(getattr(loops, actuator))
            rows.append(LoopRow(point, actuator, wake, factor, loops, margins))
    return rows


def _acting(point: LoopPoint) -> list[Actuator]:
    found: list[Actuator] = []
    if point.torque_acts:
        found.append("torque")
    if point.pitch_acts:
        found.append("pitch")
    return found


def bode_drawing(
    design: TurbineDesign, rows: Sequence[LoopRow], actuator: Actuator, wake: str
) -> Figure:
    """Return the Bode plot of the loops that are broken at an actuator, for one wake."""
    turbine = design.turbine
    lines = []
    for row in rows:
        if row.actuator == actuator and row.wake == wake:
            response = loop_response(getattr(row.loops, actuator), frequencies=FREQUENCY)
            lines.append(bode_line(f"{row.loop.wind:g} m/s", response, row.margins, FREQUENCY))
    if not lines:
        lines = [BodeLine("no wind", np.zeros(len(FREQUENCY), dtype=np.complex128))]
    tower = float(np.sqrt(turbine.tower_stiffness / turbine.tower_mass))
    speed = design.settings.speed_setpoint or turbine.rated_rotor_speed
    marks = {f"tower {tower / 2 / np.pi:.2f} Hz": tower, "3P": 3 * speed}
    return bode_figure(FREQUENCY, lines, marks=marks)
