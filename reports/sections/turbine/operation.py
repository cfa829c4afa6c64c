"""Steady operation for the page: trim points over wind, and where each region begins."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.turbine.trim import (
    TrimPoint,
    optimal_tip_speed_ratio,
    rated_wind,
    trim,
)

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["region_starts", "trim_curve"]


def region_starts(design: TurbineDesign) -> dict[str, float]:
    """Return region -> wind at which it begins [m/s], those inside cut-in to cut-out."""
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
    """Return the turbine's trim from cut-in to cut-out, the regions' ends among the winds."""
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    count = int(round((turbine.cut_out - turbine.cut_in) / step)) + 1
    winds = np.linspace(turbine.cut_in, turbine.cut_out, count)
    every = np.union1d(winds, list(region_starts(design).values()))
    return tuple(trim(turbine, float(v), speed_setpoint=setpoint) for v in every)
