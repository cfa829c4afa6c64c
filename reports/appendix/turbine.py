"""The appendix of a turbine: plant, law, blending, margins at the trims, figures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Figure as DataFigure
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint, optimal_tip_speed_ratio, rated_wind, trim
from takagi.reports.appendix.tex import (
    NONE,
    Tex,
    decimal,
    escape,
    matrix,
    scientific,
    unit,
    with_decimals,
)
from takagi.reports.loops.turbine_local import LoopPoint, loop_points
from takagi.reports.margins.margins import Margins, disk_margin, loop_margins
from takagi.reports.margins.turbine_loops import Loops, loops_at_trim
from takagi.reports.sections.turbine.cells import filter_of
from takagi.reports.sections.turbine.model import power_surface, trim_drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEGREES = 180 / np.pi
RPM = 30 / np.pi
_SYMBOLS = {
    "rotor.radius": "R",
    "rotor.inertia": "J_r",
    "rotor.rated_speed": r"\omega_\mathrm{rated}",
    "rotor.air_density": r"\rho",
    "drivetrain.gear_ratio": "n_g",
    "generator.inertia": "J_g",
    "generator.rated_torque": r"T_\mathrm{rated}",
    "generator.maximum_torque": r"T_\mathrm{top}",
    "pitch.minimum": r"\beta_\mathrm{min}",
    "pitch.maximum": r"\beta_\mathrm{max}",
    "pitch.rate_limit": r"\dot\beta_\mathrm{max}",
    "pitch.time_constant": r"\tau_\beta",
    "operation.cut_in": r"v_\mathrm{in}",
    "operation.cut_out": r"v_\mathrm{out}",
}
# Sections of a turbine's file with published results and with another controller's numbers: nothing
# in the appendix depends on them.
_LEFT_OUT = ("reference", "baseline")
_WINDS = (*range(3, 12), 11.4, 11.5, 12, 13, 14, 16, 18, 20, 22, 24, 25)


def plant_context(design: TurbineDesign) -> dict[str, object]:
    """Return the values for the sections on plant, surface, trim and observer."""
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    surface = turbine.torque
    low, high = (end * DEGREES for end in surface.y_range)
    return {
        "turbine": turbine.name,
        "parameters": _parameters(turbine),
        "inertia": scientific(turbine.inertia, 8),
        "torque_constant": scientific(turbine.torque_constant, 8),
        "surface_size": Tex(rf"${surface.coefficients.shape[0]} \times "
                            rf"{surface.coefficients.shape[1]}$"),
        "ratio_range": Tex(rf"$[{surface.x_range[0]:g},\ {surface.x_range[1]:g}]$"),
        "pitch_range": Tex(rf"$[{low:.4g}^\circ,\ {high:.4g}^\circ]$"),
        "setpoint": with_decimals(setpoint or turbine.rated_rotor_speed, 5),
        "derated": setpoint is not None,
        "rated_wind": with_decimals(rated_wind(turbine, speed_setpoint=setpoint), 3),
        "optimal_ratio": with_decimals(optimal_tip_speed_ratio(turbine), 3),
        "trims": [_trim_row(point) for point in trim_points(design)],
        "observer": _observer(design),
        "frozen_wake_source": turbine.frozen_wake.source,
    }  # fmt: skip


def table_winds(turbine: Turbine) -> tuple[float, ...]:
    """Return the winds of the trim table from cut-in to cut-out [m/s]."""
    inside = [float(v) for v in _WINDS if turbine.cut_in <= v <= turbine.cut_out]
    return tuple(sorted({turbine.cut_in, *inside, turbine.cut_out}))


def trim_points(design: TurbineDesign) -> list[TrimPoint]:
    """Return the turbine's trims at the winds of the table."""
    setpoint = design.settings.speed_setpoint
    return [trim(design.turbine, v, speed_setpoint=setpoint) for v in table_winds(design.turbine)]


def _parameters(turbine: Turbine) -> list[list[Tex]]:
    rows = []
    for path, figure in turbine.figures.items():
        section, _, key = path.partition(".")
        if section not in _LEFT_OUT:
            rows.append(_parameter(path, f"{section}: {key.replace('_', ' ')}", figure))
    return rows


def _parameter(path: str, words: str, figure: DataFigure) -> list[Tex]:
    symbol = Tex(f"${_SYMBOLS[path]}$") if path in _SYMBOLS else Tex("")
    return [
        escape(words),
        symbol,
        scientific(figure.value, 8),
        unit(figure.unit),
        escape(figure.source),
    ]


def _trim_row(point: TrimPoint) -> list[Tex]:
    return [
        with_decimals(point.wind, 1),
        escape(point.region),
        with_decimals(point.rotor_speed, 4),
        with_decimals(point.rotor_speed * RPM, 2),
        with_decimals(point.pitch * DEGREES, 2),
        with_decimals(point.torque / 1e3, 3),
    ]


def _observer(design: TurbineDesign) -> dict[str, object]:
    observer = design.observer
    premise = observer.model.premises[0]
    return {
        "l1": with_decimals(observer.gains[0], 4),
        "l2": with_decimals(observer.gains[1], 4),
        "decay": with_decimals(observer.decay_rate, 3),
        "low": scientific(float(premise.lower), 6),
        "high": scientific(float(premise.upper), 6),
        "gain": matrix([[observer.gains[0]], [observer.gains[1]]]),
    }


def blending_context(design: TurbineDesign) -> dict[str, object]:
    """Return the numbers of the filter, its corners, and the count of rules."""
    coupling = filter_of(design)
    low, high = coupling.torque_corners
    ramp = coupling.speed_ramp
    law = design.law if isinstance(design.law, PublishedLaw) else None
    n_b, n_c = len(design.partial_load.rules), len(design.full_load.rules)
    slopes = coupling.torque_slope_range
    return {
        "paper_law": law is not None,
        "law_name": design.law.name,
        "tracking_time": None if law is None or law.tracking_time is None
        else with_decimals(law.tracking_time, 1),
        "variant": coupling.variant,
        "shape": ramp.shape,
        "corners": [matrix(corner, digits=6) for corner in coupling.corners],
        "f2_low": scientific(low, 6),
        "f2_high": scientific(high, 6),
        "ramp_start": with_decimals(ramp.start, 5),
        "ramp_end": with_decimals(ramp.end, 5),
        "speed_overlap": scientific(ramp.width),
        "torque_overlap": scientific(coupling.torque_overlap, 6),
        "minimum_torque": scientific(coupling.minimum_torque, 8),
        "maximum_torque": scientific(coupling.rated_torque, 8),
        "top_torque": scientific(coupling.top_torque, 8),
        "slopes": Tex(f"[{slopes[0]:.4g},\\ {slopes[1]:.4g}]"),
        "n_b": n_b,
        "n_c": n_c,
        "n_rules": 4 * n_b * n_c,
    }  # fmt: skip


def law_context(design: TurbineDesign) -> dict[str, Any]:
    """Return constants and gain table of the effort-sharing law; for another law a flag alone."""
    law = design.effort_sharing_law
    if law is None:
        return {"coherent": False}
    return {
        "coherent": True,
        "overlap": scientific(law.schedule.overlap),
        "wind_filter": decimal(law.wind_filter),
        "pitch_lead": with_decimals(law.feedforward.pitch_lead, 3),
        "integral_limit": scientific(law.integral_limit),
        "effort_torque": scientific(law.effort_torque, 8),
        "rated_torque": scientific(law.rated_torque, 8),
        "nodes": len(law.schedule.wind),
        "gain_rows": [_gain_row(design, law, k) for k in range(len(law.schedule.wind))],
        "limited": design.effort is not None and bool(design.effort.torque_limited.any()),
    }


def _gain_row(design: TurbineDesign, law: EffortSharingLaw, k: int) -> list[Tex]:
    table, gains, turbine = law.schedule, law.gains, design.turbine
    wind = float(table.wind[k])
    last = k == len(table.wind) - 1
    limited = design.effort is not None and bool(design.effort.torque_limited[k])
    return [
        escape(k + 1),
        with_decimals(wind, 4),
        with_decimals(table.rotor_speed[k], 4),
        with_decimals(table.trim_effort[k], 5),
        with_decimals(table.pitch(wind, turbine) * DEGREES, 2),
        with_decimals(table.torque(wind, turbine) / 1e3, 2),
        with_decimals(law.pitch_share(wind), 3),
        with_decimals(table.effectiveness[k], 4),
        with_decimals(table.effectiveness_limit[k], 4),
        Tex(with_decimals(gains.proportional[k], 5) + (r"\rlap{$^\dagger$}" if limited else "")),
        NONE if last else with_decimals(gains.integral_rate[k], 6),
        NONE if last else with_decimals(law.feedforward.inertia[k], 4),
        NONE if last else with_decimals(law.feedforward.effort_limit[k], 4),
    ]


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
        "margin_rows": [_margin_row(item) for item in loops],
        "unstable": ", ".join(f"{item.wind:g}" for item in loops if item.loops.decay_rate <= 0),
        "without_equilibrium": ", ".join(f"{wind:g}" for wind in none),
    }


def _margin_row(item: TrimLoops) -> list[Tex]:
    torque = loop_margins(item.loops.torque) if item.at.torque_acts else None
    pitch = loop_margins(item.loops.pitch) if item.at.pitch_acts else None
    frozen = NONE if item.frozen is None else with_decimals(disk_margin(item.frozen.pitch).alpha, 2)
    return [
        with_decimals(item.wind, 1),
        escape(item.at.point.region),
        *_margin_cells(torque),
        *_margin_cells(pitch),
        frozen,
        with_decimals(item.loops.decay_rate, 4),
    ]


def _margin_cells(margins: Margins | None) -> list[Tex]:
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
    from takagi.reports.figures.operation import membership_figure

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
    from takagi.reports.figures.cells import cells_figure

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
    from takagi.reports.figures.loops import poles_figure

    if not loops:
        return None
    return poles_figure([item.wind for item in loops], [item.loops.poles for item in loops])


def _bode(loops: list[TrimLoops], channel: str) -> Figure | None:
    from takagi.reports.figures.loops import BodeLine, bode_figure
    from takagi.reports.margins.margins import loop_margins
    from takagi.reports.margins.response import loop_response

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
