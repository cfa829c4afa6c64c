"""The plant in words and numbers: parameters with sources, the surface, the trims."""

from __future__ import annotations

import numpy as np

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.turbine.data import Figure, Turbine
from takagi.models.turbine.trim import TrimPoint, optimal_tip_speed_ratio, rated_wind, trim
from takagi.reports.appendix.tex import Tex, escape, matrix, scientific, unit, with_decimals

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


def _parameter(path: str, words: str, figure: Figure) -> list[Tex]:
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
