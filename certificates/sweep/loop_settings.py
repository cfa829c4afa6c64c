"""The loop at a point of a sweep: turbine, law, box and uncertainty from axis values."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.claims.turbine.wind_class import WindClass
from takagi.certificates.sweep.axis import AxisKind
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.splines.surface import Surface
from takagi.models.turbine.data import Turbine

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.settings import DesignSettings

# The default of the largest requested wind rate over all winds [m/s^2].
FULL_RATE = max(WindClass().rate)

AXES = (
    AxisKind("overlap", "rad/s^2", "half the width of effort over which torque and pitch both act"),
    AxisKind("bandwidth", "1/s", "proportional action aimed at where pitch acts"),
    AxisKind("partial-bandwidth", "1/s", "the same where torque alone acts"),
    AxisKind("effectiveness", "-", "pitch effectiveness assumed, a share of the frozen wake's"),
    AxisKind("pitch-lag", "s", "time constant of the pitch drive"),
    AxisKind(
        "inertia", "-", "uncertainty of the inertia, a share of nominal", highest=0.9, closed=True
    ),
    AxisKind(
        "frozen-wake",
        "-",
        "share of the frozen wake's pitch effectiveness",
        highest=3.0,
        closed=True,
    ),
    AxisKind(
        "power-coefficient",
        "-",
        "uncertainty of c_P, a share of the table's",
        highest=0.9,
        closed=True,
    ),
    AxisKind(
        "wind-rate",
        "m/s^2",
        "largest |v_s'| asked for, where full load begins and beyond",
        closed=True,
    ),
    AxisKind("speed-error", "rad/s", "half width of the box in speed; the others follow"),
    AxisKind(
        "wind-share", "-", "|v - v_s| up to which the loop is enclosed, over wind", highest=0.5
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class LoopSettings:
    """One closed loop and its requirements.

    Attributes
    ----------
    turbine : with the pitch lag of the point.
    law : from two-step gains.
    shape : wind rates asked for, and proportions of wind errors.
    """

    turbine: Turbine
    law: EffortSharingLaw
    box: LoopBox
    uncertainty: LoopUncertainty
    shape: WindClass


def loop_at(turbine: Turbine, asked: DesignSettings, at: Mapping[str, float]) -> LoopSettings:
    """Return the loop with the settings of a design, except those that the axes change.

    Parameters
    ----------
    at : axis name -> value; a name that is missing keeps the setting.

    Raises
    ------
    ModelError : values for which there is no trim or no gain; names the wind and what to relax.
    """
    from takagi.lmi.turbine.effort import EffortSettings, effort_gains
    from takagi.models.laws.effort_sharing.schedule import effort_schedule

    unknown = sorted(set(at) - {kind.name for kind in AXES})
    if unknown:
        raise ModelError(f"axis {unknown[0]!r} is not one of the effort-sharing law's")
    plant = replace(turbine, pitch_time_constant=at.get("pitch-lag", turbine.pitch_time_constant))
    box, uncertainty = _box(asked.box, at), _uncertainty(asked.uncertainty, at)
    effort = asked.effort or EffortSettings()
    changed: dict[str, Any] = {}
    if "speed-error" in at:
        changed["speed_error"] = float(box.speed_signal)
    if "bandwidth" in at:
        changed["bandwidth"] = at["bandwidth"]
    if "partial-bandwidth" in at:
        changed["partial_bandwidth"] = at["partial-bandwidth"]
    if "inertia" in at:
        span = uncertainty.inertia
        changed["inertia"] = (float(span.lower), float(span.upper))
    schedule = effort_schedule(
        plant,
        overlap=at.get("overlap", asked.overlap),
        effectiveness_share=at.get("effectiveness", asked.effectiveness_share),
        speed_setpoint=asked.speed_setpoint,
    )
    if "frozen-wake" in at:
        limit = np.round(at["frozen-wake"] * schedule.effectiveness_limit, 6)
        schedule = replace(schedule, effectiveness_limit=limit)
    gains = effort_gains(plant, schedule, replace(effort, **changed)).gains
    return LoopSettings(
        plant, EffortSharingLaw.of(plant, schedule, gains), box, uncertainty, _shape(at)
    )


def model_numbers(turbine: Turbine) -> dict[str, Any]:
    """Return every number of a turbine that a result can depend on, as JSON values.

    The coefficient tables are long; the SHA-256 of their knots and coefficients represents them.
    """
    found: dict[str, Any] = {}
    for field in fields(turbine):
        value = getattr(turbine, field.name)
        if isinstance(value, Surface):
            parts = (value.x_knots, value.y_knots, value.coefficients)
            data = b"".join(np.ascontiguousarray(part).tobytes() for part in parts)
            found[field.name] = hashlib.sha256(data).hexdigest()
        elif isinstance(value, float | int | str):
            found[field.name] = value
    wake = turbine.frozen_wake
    return found | {
        "frozen_wake": [np.asarray(wake.wind).tolist(), np.asarray(wake.power_sensitivity).tolist()]
    }


def _box(box: LoopBox, at: Mapping[str, float]) -> LoopBox:
    if "speed-error" in at:
        wanted = _decimal(at["speed-error"])
        share = wanted / box.speed_error
        box = replace(
            box,
            speed_error=wanted,
            effort_lag=_short(box.effort_lag * share),
            speed_signal=_short(box.speed_signal * share),
        )
    if "wind-share" in at:
        box = replace(box, wind_share=_decimal(at["wind-share"]))
    return box


def _uncertainty(uncertainty: LoopUncertainty, at: Mapping[str, float]) -> LoopUncertainty:
    if "inertia" in at:
        uncertainty = replace(uncertainty, inertia=_around_one(at["inertia"]))
    if "power-coefficient" in at:
        share = at["power-coefficient"]
        uncertainty = replace(uncertainty, power_coefficient=_around_one(share))
    if "frozen-wake" in at:
        uncertainty = replace(uncertainty, frozen_wake=at["frozen-wake"] > 0)
    return uncertainty


def _shape(at: Mapping[str, float]) -> WindClass:
    shape = WindClass()
    if "wind-rate" not in at:
        return shape
    factor = at["wind-rate"] / FULL_RATE
    return replace(shape, rate=tuple(factor * rate for rate in shape.rate))


def _around_one(share: float) -> Interval:
    return Interval(1 - _decimal(share), 1 + _decimal(share))


def _decimal(value: float) -> Fraction:
    """Return the number as it is written: a certificate states decimals."""
    return Fraction(f"{value:.9g}")


def _short(value: Fraction) -> Fraction:
    """Return four digits of a number, rounded down."""
    return _decimal(float(f"{float(value) * (1 - 1e-12):.4g}"))
