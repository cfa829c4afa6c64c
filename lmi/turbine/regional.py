r"""Gains of the two regions from LMIs: decay rate, and actuators kept within their limits.

Partial load, states (speed error, integral), command dT: the torque T* + dT stays within
0..T_max at every wind of the region.  Full load, states (speed error, pitch deviation, integral),
command d_ref: the pitch reference stays above the smallest pitch, and the rate that it demands of
the drive, (d_ref - delta_beta)/tau, within the pitch rate limit.

All this holds on the ellipsoid V = x' P x <= 1, which contains the stated operating set, lies in
the box where the model is exact, and is invariant: V decays at constant wind, v = v_hat.  So the
operating set is "every state that is reached from these errors at a constant wind".  A moving wind
and an integral that starts elsewhere are not part of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.answer import Status, Try
from takagi.lmi.balance import nearest_power
from takagi.lmi.common_lyapunov import rate_of
from takagi.lmi.diagnosis import binding_items
from takagi.lmi.stages import Outcome, decide, optimise
from takagi.lmi.term import Condition
from takagi.lmi.turbine.regional_condition import ActuatorBound, regional_gain_condition
from takagi.models.errors import ModelError
from takagi.models.ts_model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.full_load import full_load_model
from takagi.models.turbine.partial_load import partial_load_model
from takagi.models.turbine.regional_model import PITCH_DEVIATION, SPEED_ERROR, WIND_ESTIMATE
from takagi.models.turbine.trim import TrimPoint, trim

__all__ = [
    "FULL_LOAD",
    "PARTIAL_LOAD",
    "RegionGains",
    "RegionalGains",
    "Requirement",
    "region_gains",
    "regional_gains",
]

Floats: TypeAlias = NDArray[np.float64]

RELAXATION = "none needed: one input matrix in all rules"
WIND_SAMPLES = 43
# The least demand is approached to this share; at the least value no inequality has room.
OBJECTIVE_SLACK = 1e-2
BISECTIONS = 8


@dataclass(frozen=True, slots=True)
class Requirement:
    """What is asked of one region.

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
class RegionGains:
    """Gains of one region with the published signs, or why there are none.

    Attributes
    ----------
    region : "partial load" or "full load".
    model : the regional model, its rules in the order of the gains.
    requirement : what was asked.
    status : "candidate" (the LMIs held by eigenvalues; floating point, not a proof),
        "infeasible" or "unknown".
    k_x : (r, n - 1), on speed error [rad/s] (and pitch [rad]); u = -k_x dx + k_I x_I.
    k_I : (r,), on x_I = int (omega_ref - omega) [rad]; K_I = -k_I in u = -K x.
    P : (n, n); the bounds hold on x' P x <= 1.
    decay_rate : the rate that P shows for the closed rules [1/s], at least the one asked.
    bounds : name -> (limit, largest value on the ellipsoid), SI units.
    relaxation : of the double sum.
    condition, tries : what was solved, in scaled coordinates, and every word of the solvers.
    diagnosis : condition, region, winds, and what to relax; empty for a candidate.
    """

    region: str
    model: TSModel
    requirement: Requirement
    status: Status
    k_x: Floats | None
    k_I: Floats | None
    P: Floats | None
    decay_rate: float | None
    bounds: dict[str, tuple[float, float]]
    relaxation: str
    condition: Condition
    tries: tuple[Try, ...]
    diagnosis: str

    @property
    def found(self) -> bool:
        """Whether there are gains."""
        return self.status == "candidate"

    @property
    def gains(self) -> Floats:
        """K, (r, 1, n), for u = -sum h_i K_i x; ModelError with the diagnosis without gains."""
        k_x, k_I = self.require()
        return np.concatenate([k_x, -k_I[:, None]], axis=1)[:, None, :]

    def require(self) -> tuple[Floats, Floats]:
        """Return (k_x, k_I); ModelError with the diagnosis when there are none."""
        if self.k_x is None or self.k_I is None:
            raise ModelError(self.diagnosis)
        return self.k_x, self.k_I


@dataclass(frozen=True, slots=True, eq=False)
class RegionalGains:
    """The gains of partial and full load."""

    partial: RegionGains
    full: RegionGains

    @property
    def found(self) -> bool:
        """Whether both regions have gains."""
        return self.partial.found and self.full.found

    @property
    def diagnosis(self) -> str:
        """Why a region has none; empty when both have."""
        return "; ".join(part.diagnosis for part in (self.partial, self.full) if part.diagnosis)


def regional_gains(
    turbine: Turbine,
    *,
    partial_load: Requirement = PARTIAL_LOAD,
    full_load: Requirement = FULL_LOAD,
    partial_model: TSModel | None = None,
    full_model: TSModel | None = None,
    speed_setpoint: float | None = None,
) -> RegionalGains:
    """Return the gains of both regions; a region without any carries a diagnosis.

    Parameters
    ----------
    partial_load, full_load : decay rate and operating set of each region.
    partial_model, full_model : regional models; None makes them with their default bands.
    speed_setpoint : de-rated rotor speed [rad/s], the one of the models; None takes the rated.

    Raises
    ------
    ModelError : misuse only (a set outside the model's box, a model of something else).
    """
    low = partial_model or partial_load_model(turbine, speed_setpoint=speed_setpoint)
    high = full_model or full_load_model(turbine, speed_setpoint=speed_setpoint)
    return RegionalGains(
        region_gains(turbine, low, partial_load, speed_setpoint=speed_setpoint),
        region_gains(turbine, high, full_load, speed_setpoint=speed_setpoint),
    )


def region_gains(
    turbine: Turbine,
    model: TSModel,
    requirement: Requirement,
    *,
    speed_setpoint: float | None = None,
) -> RegionGains:
    """Return the gains of the region that a model describes.

    Of all gains that meet the requirement, those that ask least of the actuator on the ellipsoid:
    the smallest torque (partial load), the smallest demanded pitch rate (full load).

    Raises
    ------
    ModelError : the operating set is not inside the model's box, or the input matrix varies.
    """
    task = _task(turbine, model, requirement, speed_setpoint)
    condition = task.condition(requirement)
    outcome = optimise(condition, slack=OBJECTIVE_SLACK)
    if outcome.status != "candidate":
        said = _diagnosis(task, condition, outcome)
        return RegionGains(
            task.region, model, requirement, outcome.status, None, None, None, None, {},
            RELAXATION, condition, outcome.tries, said,
        )  # fmt: skip
    Q, M = outcome.values["Q"][0], outcome.values["M"][:, 0, :]
    K = np.linalg.solve(Q, M.T).T * task.unit / task.scales
    P = np.linalg.inv(Q) / np.outer(task.scales, task.scales)
    return RegionGains(
        task.region,
        model,
        requirement,
        "candidate",
        K[:, :-1],
        -K[:, -1],
        P,
        rate_of(model.A - model.B @ K[:, None, :], P),
        {bound.name: (bound.limit, _largest(P, K + bound.offset)) for bound in task.bounds},
        RELAXATION,
        condition,
        outcome.tries,
        "",
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
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


def _task(
    turbine: Turbine, model: TSModel, requirement: Requirement, speed_setpoint: float | None
) -> _Task:
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
    # The integral of an error that decays at the rate asked for has this size.
    ranges = np.where(np.isfinite(box), box, box[0] / requirement.decay_rate)
    return _Task(
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


def _largest(P: Floats, rows: Floats) -> float:
    """Return max |row x| over the rows and x' P x <= 1."""
    return float(np.sqrt(np.einsum("ij,ji->i", rows, np.linalg.solve(P, rows.T)).max()))


def _diagnosis(task: _Task, condition: Condition, outcome: Outcome) -> str:
    low, high = (float(end) for end in task.model.box[WIND_ESTIMATE])
    names = [lmi.name for lmi in condition.lmis]
    asked = task.requirement
    said = (
        f"{task.region}, {low:.4g} to {high:.4g} m/s: no gains were found ({outcome.status}) with "
        f"decay rate {asked.decay_rate:.4g} 1/s from speed errors up to {asked.speed_error:.4g} "
        f"rad/s and pitch errors up to {asked.pitch_error:.4g} rad"
    )
    if outcome.multipliers:
        said += f": {binding_items(condition, outcome.multipliers, *names)}"
    slower = _largest_share(task, lambda s: replace(asked, decay_rate=s * asked.decay_rate))
    smaller = _largest_share(
        task,
        lambda s: replace(
            asked, speed_error=s * asked.speed_error, pitch_error=s * asked.pitch_error
        ),
    )
    free = decide(task.condition(asked, bounded=False)).status == "candidate"
    unboxed = decide(task.condition(asked, boxed=False)).status == "candidate"
    cures = [f"lower the decay rate to {slower * asked.decay_rate:.3g} 1/s"] if slower else []
    if smaller:
        cures.append(f"shrink the operating set to {smaller:.0%}")
    if free:
        cures.append("widen the actuator limits (without them there are gains)")
    if unboxed:
        cures.append(
            "give the model wider bands, if its bounds allow (the ellipsoid does not fit into them)"
        )
    cures.append("narrow the wind range, so that the rules differ less")
    return f"{said}; relax one of these: {', or '.join(cures)}"


def _largest_share(task: _Task, scaled: Callable[[float], Requirement]) -> float:
    """Return the largest share, in steps, at which there are gains; 0 for none down to 1/32."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if decide(task.condition(scaled(middle))).status == "candidate":
            low = middle
        else:
            high = middle
        if high < 1 / 32:
            return 0.0
    return low
