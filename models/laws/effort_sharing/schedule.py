r"""The effort-sharing law's tables over wind: reference speed, trim effort, pitch effectiveness.

At wind v the trim effort q* is the root of

    T_r(omega*, beta_min + psi(q) / b, v) = n_g T_rated - J psi(-q),

which is negative if torque is held in reserve, and positive if pitch must reduce the rotor torque.
b(v) > 0 is the assumed pitch effectiveness [rad/s^2 per rad].  Between the nodes every column is
linear in v, so the emitted tables define the law. Between the nodes the torque balance has a
residual, which the certificate encloses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats, frozen
from takagi.models.errors import ModelError
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import Turbine, rotor_torque
from takagi.models.turbine.trim import (
    TABLE_SHARE,
    optimal_tip_speed_ratio,
    rated_wind,
    reference_speed,
)

DEFAULT_OVERLAP = 0.01
DEFAULT_EFFECTIVENESS_SHARE = 1.0
# Spacing of the nodes [m/s]: fine where the trim effort bends, around rated wind.
COARSE, FINE = 0.5, 0.1
FINE_FROM_RATED = (-0.9, 1.6)
SLOW_WIND_SPACING = 0.25
SMALLEST_REDUCTION = 1e-3  # rad/s, over which a secant is taken


@dataclass(frozen=True, slots=True, eq=False)
class EffortSchedule:
    """Trim columns over wind, linear between the nodes.

    Attributes
    ----------
    wind : (K,) nodes [m/s], increasing.
    rotor_speed : (K,) omega* [rad/s].
    trim_effort : (K,) q* [rad/s^2].
    effectiveness : (K,) b, assumed pitch effectiveness [rad/s^2 per rad], positive.
    effectiveness_limit : (K,) the frozen-wake effectiveness, the largest considered possible.
    overlap : eps of the effort ramp [rad/s^2].
    """

    wind: Floats
    rotor_speed: Floats
    trim_effort: Floats
    effectiveness: Floats
    effectiveness_limit: Floats
    overlap: float

    def __post_init__(self) -> None:
        columns = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
        for name in columns:
            column = frozen(self, name)
            if column.shape != np.shape(self.wind) or not np.all(np.isfinite(column)):
                raise ModelError(
                    f"schedule column {name} has shape {column.shape} or a non-finite entry; one "
                    f"finite number per wind node is needed ({np.shape(self.wind)})"
                )
        if len(self.wind) < 2 or np.any(np.diff(self.wind) <= 0):
            raise ModelError("schedule winds must increase and be at least two")
        if self.overlap <= 0 or np.any(self.effectiveness <= 0):
            raise ModelError("the overlap and every pitch effectiveness must be positive")

    def pitch(self, wind: float, turbine: Turbine) -> float:
        """Return the trim pitch beta_min + psi(q*) / b [rad]."""
        q = float(np.interp(wind, self.wind, self.trim_effort))
        b = float(np.interp(wind, self.wind, self.effectiveness))
        return turbine.pitch_min + float(effort_ramp(q, self.overlap)) / b

    def torque(self, wind: float, turbine: Turbine) -> float:
        """Return the trim torque T_rated - (J / n_g) psi(-q*) [N m, high-speed shaft]."""
        q = float(np.interp(wind, self.wind, self.trim_effort))
        reserve = float(effort_ramp(-q, self.overlap))
        return turbine.rated_torque - turbine.inertia / turbine.gear_ratio * reserve


def frozen_wake_effectiveness(turbine: Turbine, wind: float) -> float:
    """Return -dT_r/dbeta / J with the induction held [rad/s^2 per rad].

    The published dP/dbeta over the rated speed and the inertia, linear between its winds; below its
    first wind it falls with the square of the wind, as torque at constant tip-speed ratio does.

    Source: the turbine file's frozen-wake column (Jonkman et al. 2009 for the NREL 5 MW).
    """
    table = turbine.frozen_wake
    sensitivity = -np.interp(wind, table.wind, table.power_sensitivity)
    share = min(1.0, wind / table.wind[0]) ** 2
    return float(sensitivity * share / (turbine.rated_rotor_speed * turbine.inertia))


def effort_schedule(
    turbine: Turbine,
    *,
    overlap: float = DEFAULT_OVERLAP,
    effectiveness_share: float = DEFAULT_EFFECTIVENESS_SHARE,
    speed_setpoint: float | None = None,
) -> EffortSchedule:
    """Return the trim columns from cut-in to cut-out, rounded to the decimals that are emitted.

    Parameters
    ----------
    overlap : eps [rad/s^2].
    effectiveness_share : b(v) is this share of the frozen-wake effectiveness at max(v, first
        published wind).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.

    Raises
    ------
    ModelError : no trim at some wind; the message names it.
    """
    if overlap <= 0 or effectiveness_share <= 0:
        raise ModelError(
            f"overlap {overlap:.4g} rad/s^2 and effectiveness share {effectiveness_share:.4g} "
            "were given; both must be positive"
        )
    wind = _nodes(turbine, speed_setpoint)
    speed = [round(reference_speed(turbine, v, speed_setpoint=speed_setpoint), 9) for v in wind]
    floor = turbine.frozen_wake.wind[0]
    effectiveness = [
        round(effectiveness_share * frozen_wake_effectiveness(turbine, max(v, floor)), 6)
        for v in wind
    ]
    limit = [round(frozen_wake_effectiveness(turbine, v), 6) for v in wind]
    effort = [
        round(effort_at_rest(turbine, v, w, b, overlap, turbine.rated_torque), 9)
        for v, w, b in zip(wind, speed, effectiveness, strict=True)
    ]
    return EffortSchedule(
        np.array(wind),
        np.array(speed),
        np.array(effort),
        np.array(effectiveness),
        np.array(limit),
        overlap,
    )


def speed_effort(turbine: Turbine, schedule: EffortSchedule, lowest_speed: float) -> Floats:
    """Return s at the nodes: the change of trim effort over that of the reference speed [1/s].

    The secant from omega* to the lowest speed set-point [rad/s], at rated torque; where omega* is
    not above that speed, which is at low winds, the first one.

    Raises
    ------
    ModelError : no trim at the lowest speed.
    """
    columns = (schedule.wind, schedule.rotor_speed, schedule.effectiveness, schedule.trim_effort)
    secants: list[float | None] = []
    for v, speed, b, effort in zip(*(column.tolist() for column in columns), strict=True):
        if speed < lowest_speed + SMALLEST_REDUCTION:
            secants.append(None)
            continue
        slower = effort_at_rest(turbine, v, lowest_speed, b, schedule.overlap, turbine.rated_torque)
        secants.append(round((slower - effort) / (lowest_speed - speed), 6))
    first = next((secant for secant in secants if secant is not None), None)
    if first is None:
        return np.zeros(len(secants))
    return np.array([first if secant is None else secant for secant in secants])


def _nodes(turbine: Turbine, speed_setpoint: float | None) -> list[float]:
    """Return the winds of the table: every kink of omega*(v), and closer nodes where q* bends."""
    ratio = optimal_tip_speed_ratio(turbine)
    top = speed_setpoint or turbine.rated_rotor_speed
    minimum = turbine.minimum_rotor_speed
    radius = turbine.rotor_radius
    largest = TABLE_SHARE * turbine.torque.x_range[1]
    # omega*(v) bends where the table's end stops to limit the tip-speed ratio, where minimum speed
    # has the best ratio, and where the set-point is reached.
    kinks = [minimum * radius / largest, minimum * radius / ratio, top * radius / ratio]
    rated = rated_wind(turbine, speed_setpoint=speed_setpoint)
    fine = [rated + edge for edge in FINE_FROM_RATED]
    spans = [
        (turbine.cut_in, 5.0, SLOW_WIND_SPACING),
        (5.0, fine[0], COARSE),
        (fine[0], fine[1], FINE),
        (fine[1], turbine.cut_out, COARSE),
    ]
    nodes = {turbine.cut_out, *(k for k in kinks if turbine.cut_in < k < turbine.cut_out)}
    for start, stop, spacing in spans:
        # A machine may begin above 5 m/s, or end soon after rated wind.
        start, stop = max(start, turbine.cut_in), min(stop, turbine.cut_out)
        if stop > start:
            steps = int(np.ceil((stop - start) / spacing))
            nodes.update(np.linspace(start, stop, steps, endpoint=False).tolist())
    return _merged(sorted(round(float(v), 4) for v in nodes), kinks)


def _merged(nodes: list[float], kinks: list[float]) -> list[float]:
    """Return the nodes without those that are too close to another; kinks and both ends stay."""
    fixed_nodes = [round(k, 4) for k in kinks]
    merged = [nodes[0]]
    for v in nodes[1:-1]:
        gap = v - merged[-1]
        if (
            v in fixed_nodes
            and gap < FINE / 2
            and merged[-1] not in fixed_nodes
            and len(merged) > 1
        ):
            merged[-1] = v
        elif v in fixed_nodes or gap >= FINE / 2:
            merged.append(v)
    return [*merged, nodes[-1]]


def effort_at_rest(
    turbine: Turbine, v: float, omega: float, b: float, overlap: float, torque: float
) -> float:
    """Return the effort at which the torques balance, with this torque in place of rated torque.

    ``v`` : wind [m/s].   omega : rotor speed [rad/s].   b : assumed pitch effectiveness
    [rad/s^2 per rad].   overlap : eps [rad/s^2].   torque : [N m, high-speed shaft].

    Raises
    ------
    ModelError : no balance within the tables.
    """
    from scipy.optimize import brentq

    def excess(q: float) -> float:
        pitch = turbine.pitch_min + float(effort_ramp(q, overlap)) / b
        reserve = turbine.inertia * float(effort_ramp(-q, overlap))
        demanded = turbine.gear_ratio * torque - reserve
        try:
            return float(rotor_torque(turbine, omega, pitch, v)) - demanded
        except ModelError as error:
            raise ModelError(
                f"trim at wind {v:.4g} m/s with overlap {overlap:.4g} rad/s^2: {error}; "
                "narrow the overlap"
            ) from error

    full = turbine.gear_ratio * torque / turbine.inertia
    top = b * (turbine.torque.y_range[1] - turbine.pitch_min) * 0.999
    # The first sign change from below. On the stall side of the table there may be further ones.
    grid = np.concatenate([np.linspace(-full - overlap, overlap, 9), np.linspace(overlap, top, 60)])
    values = [excess(float(q)) for q in grid]
    for k in range(len(grid) - 1):
        if values[k] >= 0 > values[k + 1] or values[k] <= 0 < values[k + 1]:
            return float(brentq(excess, grid[k], grid[k + 1], xtol=1e-14))
    raise ModelError(
        f"{turbine.name}: no trim at wind {v:.4g} m/s with rotor speed {omega:.4g} rad/s and pitch "
        f"effectiveness {b:.4g} rad/s^2 per rad; the tables end at pitch "
        f"{turbine.torque.y_range[1]:.4g} rad: narrow the wind range or change the set-point"
    )
