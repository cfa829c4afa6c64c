"""Steady operation: trim points over wind, the first wind of each region, and their figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.turbine.aerodynamics import tip_speed_ratio
from takagi.models.turbine.trim import TrimPoint, optimal_tip_speed_ratio, rated_wind, trim
from takagi.reports.figures import power_surface_figure, trim_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.arrays import Floats


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


def trim_drawing(
    design: TurbineDesign, points: Sequence[TrimPoint], regions: Mapping[str, float]
) -> Figure:
    """Return the trim over wind, with the published pitch where the speed is not de-rated."""
    turbine, published = design.turbine, design.turbine.frozen_wake
    speed, torque = (np.array([getattr(p, k) for p in points]) for k in ("rotor_speed", "torque"))
    nominal = design.settings.speed_setpoint is None
    return trim_figure(
        [p.wind for p in points],
        rotor_speed=speed,
        pitch=[p.pitch for p in points],
        torque=torque,
        power=turbine.generator_efficiency * turbine.gear_ratio * torque * speed,
        regions=regions,
        published_pitch=(published.wind, published.pitch) if nominal else None,
    )


def power_surface(
    design: TurbineDesign,
    points: Sequence[TrimPoint],
    *,
    ratio: Floats,
    pitch: Floats,
    band: float | None = None,
) -> Figure:
    """Return the power coefficient over a grid, with the trim; ``band`` as in the figure."""
    turbine = design.turbine
    along = [float(tip_speed_ratio(turbine, p.rotor_speed, p.wind)) for p in points]
    return power_surface_figure(
        ratio,
        pitch,
        turbine.power(ratio[None, :], pitch[:, None]),
        trim=(along, [p.pitch for p in points]),
        band=band,
    )
