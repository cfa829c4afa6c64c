"""Loops at the trims on the validation plant: margins for the table, responses for the figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.reports.appendix.tex import NONE, Tex, escape, with_decimals
from takagi.reports.appendix.turbine import DEGREES, table_winds
from takagi.reports.loops.turbine_local import LoopPoint, loop_points
from takagi.reports.margins import Loops, Margins, disk_margin, loop_margins, loops_at_trim


@dataclass(frozen=True, slots=True, eq=False)
class TrimLoops:
    """The linear loops at one equilibrium of the law.

    Attributes
    ----------
    at : equilibrium, local controller, and which actuators act.
    loops : the loops with the wake in equilibrium.
    frozen : the loops with the frozen wake's pitch effectiveness; None where pitch does not act.
    """

    at: LoopPoint
    loops: Loops
    frozen: Loops | None

    @property
    def wind(self) -> float:
        """Wind [m/s]."""
        return self.at.wind


def trim_loops(design: TurbineDesign) -> tuple[list[TrimLoops], tuple[float, ...]]:
    """Return the loops at the winds of the trim table, and the winds without an equilibrium."""
    points, none = loop_points(design, table_winds(design.turbine))
    return [_loops(design, point) for point in points], none


def _loops(design: TurbineDesign, at: LoopPoint) -> TrimLoops:
    def loops(effectiveness: float) -> Loops:
        return loops_at_trim(design.turbine, at.point, at.controller, effectiveness=effectiveness)

    frozen = loops(at.frozen_wake) if math.isfinite(at.frozen_wake) else None
    return TrimLoops(at, loops(1.0), frozen)


def margins_context(loops: Sequence[TrimLoops], none: Sequence[float]) -> dict[str, Any]:
    """Return the margins table, the unstable winds, and the winds without an equilibrium."""
    return {
        "margin_rows": [_row(item) for item in loops],
        "unstable": ", ".join(f"{item.wind:g}" for item in loops if item.loops.decay_rate <= 0),
        "without_equilibrium": ", ".join(f"{wind:g}" for wind in none),
    }


def _row(item: TrimLoops) -> list[Tex]:
    torque = loop_margins(item.loops.torque) if item.at.torque_acts else None
    pitch = loop_margins(item.loops.pitch) if item.at.pitch_acts else None
    frozen = NONE if item.frozen is None else with_decimals(disk_margin(item.frozen.pitch).alpha, 2)
    return [
        with_decimals(item.wind, 1),
        escape(item.at.point.region),
        *_cells(torque),
        *_cells(pitch),
        frozen,
        with_decimals(item.loops.decay_rate, 4),
    ]


def _cells(margins: Margins | None) -> list[Tex]:
    """Return gain [dB], phase [deg], delay [s], disk size and peak sensitivity of one loop."""
    if margins is None:
        return [NONE] * 5
    return [
        _decibels(margins.gain_increase),
        with_decimals(margins.phase * DEGREES, 1),
        with_decimals(margins.delay, 2),
        with_decimals(margins.disk.alpha, 2),
        with_decimals(margins.sensitivity_peak, 2),
    ]


def _decibels(factor: float) -> Tex:
    return with_decimals(20 * math.log10(factor) if 0 < factor < math.inf else factor, 1)
