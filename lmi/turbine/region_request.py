"""The design problem of one region's gains: requirement, bounds, and the scaled condition."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.turbine.regional_condition import ActuatorBound, regional_gain_condition
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.regional_model import PITCH_DEVIATION, SPEED_ERROR, WIND_ESTIMATE
from takagi.models.turbine.trim import TrimPoint, trim

WIND_SAMPLES = 43


@dataclass(frozen=True, slots=True)
class Requirement:
    """The requirement on one region's gains.

    Attributes
    ----------
    decay_rate : alpha [1/s]; V' <= -2 alpha V.
    speed_error : rotor speed errors of the operating set, up to this [rad/s].
    pitch_error : its pitch deviations, up to this [rad]; unused in partial load.
    """

    decay_rate: float
    speed_error: float
    pitch_error: float = 0.0

    def __post_init__(self) -> None:
        if not (self.decay_rate > 0 and self.speed_error > 0 and self.pitch_error >= 0):
            raise ModelError(
                f"decay rate {self.decay_rate!r} 1/s, speed error {self.speed_error!r} rad/s, "
                f"pitch error {self.pitch_error!r} rad were given; the first two must exceed 0"
            )


PARTIAL_LOAD = Requirement(decay_rate=0.1, speed_error=0.02)
FULL_LOAD = Requirement(decay_rate=0.05, speed_error=0.0125, pitch_error=0.0025)


@dataclass(frozen=True, slots=True, eq=False)
class RegionRequest:
    """One region in SI units, and the scales of its states and command."""

    region: str
    model: TSModel
    requirement: Requirement
    bounds: tuple[ActuatorBound, ...]
    box: Floats
    scales: Floats
    unit: float

    def condition(
        self, requirement: Requirement, *, bounded: bool = True, boxed: bool = True
    ) -> Condition:
        """Return the scaled condition, with or without actuator bounds and the model's box."""
        s, u = self.scales, self.unit
        scaled = tuple(
            replace(b, limit=b.limit / u, offset=b.offset * s / u) for b in self.bounds if bounded
        )
        return regional_gain_condition(
            self.model.A * s / s[:, None],
            self.model.B[0] * u / s[:, None],
            decay_rate=requirement.decay_rate,
            corners=_corners(requirement, len(s)) / s,
            bounds=scaled,
            box=self.box / s if boxed else np.full(len(s), np.inf),
        )


def region_request(
    turbine: Turbine, model: TSModel, requirement: Requirement, speed_setpoint: float | None
) -> RegionRequest:
    if model.B.shape[2] != 1 or np.ptp(model.B, axis=0).any() or SPEED_ERROR not in model.box:
        raise ModelError(
            f"model {model.name!r}: a regional model with one input, the same in all rules, and "
            f"a box in {SPEED_ERROR!r} is needed"
        )
    with_pitch = PITCH_DEVIATION in model.states
    box = np.array([_half_width(model, name) for name in model.states])
    corners = _corners(requirement, len(box))
    if np.any(np.abs(corners) > box):
        raise ModelError(
            f"{model.name}: the operating set reaches {np.abs(corners).max(axis=0)} in "
            f"{', '.join(model.states)}, the model is exact up to {box}; ask for smaller errors or "
            "make the model with wider bands"
        )
    points = [trim(turbine, v, speed_setpoint=speed_setpoint) for v in _winds(model)]
    bounds = (_pitch_bounds if with_pitch else _torque_bounds)(turbine, points)
    # The integral of an error that decays at the required rate has this size.
    ranges = np.where(np.isfinite(box), box, box[0] / requirement.decay_rate)
    return RegionRequest(
        "full load" if with_pitch else "partial load",
        model,
        requirement,
        bounds,
        box,
        nearest_power(ranges),
        float(nearest_power(np.array(bounds[0].limit))),
    )


def _half_width(model: TSModel, state: str) -> float:
    if state not in model.box:
        return np.inf
    low, high = model.box[state]
    return float(min(high, -low))


def _corners(requirement: Requirement, states: int) -> Floats:
    e, p = requirement.speed_error, requirement.pitch_error
    if states == 2:
        return np.array([[e, 0.0]])
    return np.array([[first, second, 0.0] for first, second in product((e,), (p, -p))])


def _winds(model: TSModel) -> tuple[float, ...]:
    low, high = (float(end) for end in model.box[WIND_ESTIMATE])
    return tuple(float(v) for v in np.linspace(low, high, WIND_SAMPLES))


def _torque_bounds(turbine: Turbine, points: list[TrimPoint]) -> tuple[ActuatorBound, ...]:
    """Return |dT| <= the least distance of the trim torque from 0 and from its maximum."""
    torques = [point.torque for point in points]
    limit = min(min(torques), turbine.maximum_torque - max(torques))
    return (ActuatorBound("torque within its limits", limit, np.zeros(2), True),)


def _pitch_bounds(turbine: Turbine, points: list[TrimPoint]) -> tuple[ActuatorBound, ...]:
    angles = [point.pitch for point in points]
    room = min(min(angles) - turbine.pitch_min, turbine.pitch_max - max(angles))
    if room <= 0:
        raise ModelError(
            f"{turbine.name}: the trim pitch is at a limit at {points[0].wind:.4g} m/s, so no "
            "pitch command has room on both sides; begin the wind range above rated wind"
        )
    drive = np.array([0.0, 1.0, 0.0])
    return (
        ActuatorBound("pitch reference above the smallest pitch", room, np.zeros(3)),
        # u = -K x, so |u - delta_beta| is |(K + (0, 1, 0)) x|.
        ActuatorBound(
            "demanded pitch rate (times the drive's time constant) within its limit",
            turbine.pitch_rate_limit * turbine.pitch_time_constant,
            drive,
            True,
        ),
    )
