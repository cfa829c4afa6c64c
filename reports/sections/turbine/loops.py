"""Closed-loop poles over wind; Bode plots of the law's own loops, for the appendix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.reports.figures.loops import BodeLine, bode_figure, bode_line, poles_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.turbine_local import LoopPoint, loop_points
from takagi.reports.margins.margins import Margins, loop_margins
from takagi.reports.margins.response import loop_response
from takagi.reports.margins.turbine_loops import Loops, closed_loop_poles, loops_at_trim
from takagi.reports.page.text import Section, at_least, with_decimals

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


def poles_section(design: TurbineDesign) -> Section:
    """Return the section about the poles of the design model over wind."""
    turbine = design.turbine
    winds = np.arange(np.ceil(turbine.cut_in), turbine.cut_out + 0.25, 0.5)
    points, none = loop_points(design, winds.tolist())
    poles = closed_loop_poles(
        turbine, [p.point for p in points], [p.controller for p in points], kind="design"
    )
    summary = claim_summary(design)
    rate = None
    if summary is not None and summary.verdict is Verdict.PROVED:
        rate = summary.common_rate
    figure = poles_figure(
        [p.wind for p in points],
        poles,
        decay_rate=rate or None,
        reach=6.0,
    )
    slowest = min(zip(points, poles, strict=True), key=lambda pair: -pair[1].real.max())
    return Section(
        "poles",
        "Closed-loop poles over wind",
        {
            "figure": captioned_figure(
                figure,
                "poles",
                caption="Poles of the design model with the law linearised at its trims, "
                "every 0.5 m/s. Dashed: the decay rate proved for all winds of the certificate.",
                alternative="Closed-loop poles in the complex plane coloured by wind, and the "
                "decay of the slowest pole over wind",
            ),
            "slowest": with_decimals(-float(slowest[1].real.max()), 4),
            "slowest_wind": f"{slowest[0].wind:g}",
            "stable": all(p.real.max() < 0 for p in poles),
            "none": ", ".join(f"{v:g}" for v in none),
            "certified": "" if rate is None else at_least(rate),
        },
    )


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
