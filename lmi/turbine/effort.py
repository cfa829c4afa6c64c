r"""Gains of the effort-sharing law: at each wind a guaranteed-cost LMI for the effort loop.

Around the trim at wind v the loop seen by the effort u is e' = a e - G u, x_I' = -e, with a in the
range that dT_r/domega / J has on the speed band, and 1/G in the range of the inertia.  The LMI
gives u = gamma_e e - gamma_I x_I for the weights of an operating set:

    speed error  e_max                     the band that the certificate encloses
    effort       gamma_v e_max             what torque can deliver at this wind
    integral     e_max / nu_v              an integral slower than the proportional action

gamma_v is the chosen bandwidth, but no more than leaves torque above zero on the whole operating
set (a hard limit, kept again after the LMI); nu_v is a share of the slowest pole that the loop has
where pitch is weak, so that one quadratic function can serve all winds.  Pitch rates are limited by
the law's own ramp: the certificate carries the saturation as a sector.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.gains.cost.regulator import guaranteed_cost_gain
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains
from takagi.models.laws.effort_sharing.schedule import EffortSchedule
from takagi.models.ramps import effort_ramp, effort_ramp_slope
from takagi.models.turbine.data import Turbine, rotor_torque_gradient

CURVE_POINTS = 25
# Where a bandwidth that grows with the wind has grown, over the wind at which pitch begins to act:
# 13.3 m/s for the IEA 15-MW turbine.
GROWN = 1.25


@dataclass(frozen=True, slots=True)
class EffortSettings:
    """The requirements on the effort loop.

    Attributes
    ----------
    bandwidth : proportional action aimed at where pitch acts [1/s].
    partial_bandwidth : the same where torque alone acts; a fast speed loop there only makes the
        torque vary.  At most the other; region 2.5 goes from one to the other.
    bandwidth_growth : the bandwidth at ``GROWN`` times the wind where pitch begins to act, and
        beyond, over ``bandwidth`` [-]; in between it grows with the wind.  Near rated wind pitch
        turns thrust more than torque, so that wake and tower limit the bandwidth there alone.
    speed_error : e_max of the operating set [rad/s].
    torque_share : largest share of the torque reserve to zero that the set may use [-].
    integral_share : integral rate over the slowest loop rate, where pitch acts [-].  A fast
        integral moves pitch with every gust near rated wind, where pitch is weak.
    partial_integral_share : the same where torque alone acts.
    inertia : true over nominal inertia that every gain must serve.
    """

    bandwidth: float = 0.6
    partial_bandwidth: float = 0.3
    speed_error: float = 0.03
    torque_share: float = 0.6
    bandwidth_growth: float = 1.0
    integral_share: float = 0.15
    partial_integral_share: float = 0.3
    inertia: tuple[float, float] = (0.9, 1.1)


@dataclass(frozen=True, slots=True, eq=False)
class EffortDesign:
    """Gains over the nodes, and what they were designed for.

    Attributes
    ----------
    gains : gamma (K,) and nu (K-1,), rounded to the decimals that are emitted.
    gain_pairs : (K, 2) gamma_e [1/s] and gamma_I [1/s^2] as the LMIs gave them.
    stiffness : (K, 2) range of a at each node [1/s].
    torque_limited : (K,) whether the torque limit, not the bandwidth, set the gain.
    """

    gains: EffortGains
    gain_pairs: Floats
    stiffness: Floats
    torque_limited: NDArray[np.bool_]


def effort_gains(
    turbine: Turbine, schedule: EffortSchedule, settings: EffortSettings | None = None
) -> EffortDesign:
    """Return LMI gains at every wind node of the schedule.

    Raises
    ------
    ModelError : a setting out of range, or no gain at some wind; names the wind and what to relax.
    """
    chosen = settings or EffortSettings()
    _check(chosen)
    rows = [_named_node(turbine, schedule, chosen, k) for k in range(len(schedule.wind))]
    gamma = np.array([row[0] for row in rows])
    rate = np.array([row[1] for row in rows])
    # The smaller of both nodes' values, because an interval's integral rate must suit both of its
    # ends.
    nu = np.minimum(rate[:-1], rate[1:])
    return EffortDesign(
        EffortGains(np.round(gamma, 5), np.round(nu, 6)),
        np.stack([gamma, gamma * rate], axis=1),
        np.array([row[2] for row in rows]),
        np.array([row[3] for row in rows]),
    )


def _named_node(
    turbine: Turbine, schedule: EffortSchedule, settings: EffortSettings, k: int
) -> tuple[float, float, tuple[float, float], bool]:
    """Return ``_node``; what is said about the table gets the wind and what to change."""
    try:
        return _node(turbine, schedule, settings, k)
    except ModelError as error:
        raise ModelError(
            f"at wind {schedule.wind[k]:.4g} m/s with overlap {schedule.overlap:.4g} rad/s^2 and "
            f"speed errors up to {settings.speed_error:.4g} rad/s: {error}; reduce these"
        ) from error


def _node(
    turbine: Turbine, schedule: EffortSchedule, settings: EffortSettings, k: int
) -> tuple[float, float, tuple[float, float], bool]:
    wind = float(schedule.wind[k])
    stiffness = _stiffness(turbine, schedule, settings, k)
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    reserve = full - float(effort_ramp(-schedule.trim_effort[k], schedule.overlap))
    torque_limit = settings.torque_share * reserve / settings.speed_error
    aimed = min(_bandwidth(schedule, settings, k), torque_limit)
    slowest = _least_gain(turbine, schedule, settings, k, aimed) * aimed - stiffness[1]
    share = _over_region_25(schedule, k, settings.partial_integral_share, settings.integral_share)
    integral = share * max(slowest, 0.1 * aimed)
    gains = [1 / inertia for inertia in settings.inertia]
    A = [[[a, 0.0], [-1.0, 0.0]] for a in stiffness for _ in gains]
    B = [[[-gain], [0.0]] for _ in stiffness for gain in gains]
    K = guaranteed_cost_gain(
        A,
        B,
        state_ranges=[settings.speed_error, settings.speed_error / integral],
        input_ranges=[settings.speed_error * aimed],
    )
    if K is None or K[0, 0] >= 0 or K[0, 1] <= 0:
        raise ModelError(
            f"guaranteed-cost LMI at wind {wind:.4g} m/s: no gain serves the speed slopes "
            f"{stiffness[0]:.4g} to {stiffness[1]:.4g} 1/s; lower the bandwidth "
            f"({settings.bandwidth:.4g} 1/s) or the speed error ({settings.speed_error:.4g} rad/s)"
        )
    gamma_e, gamma_i = -float(K[0, 0]), float(K[0, 1])
    limited = gamma_e > torque_limit
    return min(gamma_e, torque_limit), gamma_i / gamma_e, stiffness, limited


def _bandwidth(schedule: EffortSchedule, settings: EffortSettings, k: int) -> float:
    partial = min(settings.partial_bandwidth, settings.bandwidth)
    aimed = _over_region_25(schedule, k, partial, settings.bandwidth)
    if settings.bandwidth_growth == 1:
        return aimed
    begin = _pitch_begins(schedule)
    growth = np.interp(schedule.wind[k], (begin, GROWN * begin), (1.0, settings.bandwidth_growth))
    return aimed * float(growth)


def _pitch_begins(schedule: EffortSchedule) -> float:
    """Return the first wind of the table at which pitch must act [m/s]; the last one for none."""
    beyond = schedule.wind[schedule.trim_effort >= 0]
    return float(beyond[0] if len(beyond) else schedule.wind[-1])


def _over_region_25(schedule: EffortSchedule, k: int, partial: float, full: float) -> float:
    """Return a node's value of what is partial below region 2.5, full above, linear over it."""
    begin = schedule.wind[np.argmax(schedule.rotor_speed)]
    end = _pitch_begins(schedule)
    return float(np.interp(schedule.wind[k], (begin, max(end, begin + 1e-6)), (partial, full)))


def _stiffness(
    turbine: Turbine, schedule: EffortSchedule, settings: EffortSettings, k: int
) -> tuple[float, float]:
    """Return the least and greatest dT_r/domega / J over the speed band at the trim."""
    wind, speed = float(schedule.wind[k]), float(schedule.rotor_speed[k])
    band = speed + settings.speed_error * np.linspace(-1, 1, 9)
    slope = rotor_torque_gradient(turbine, band, schedule.pitch(wind, turbine), wind)[0]
    return float(slope.min() / turbine.inertia), float(slope.max() / turbine.inertia)


def _least_gain(
    turbine: Turbine, schedule: EffortSchedule, settings: EffortSettings, k: int, gamma: float
) -> float:
    """Return the least 1 - F (1 - sigma) along the efforts that the operating set can demand."""
    wind, speed = float(schedule.wind[k]), float(schedule.rotor_speed[k])
    reach = gamma * settings.speed_error
    effort = schedule.trim_effort[k] + reach * np.linspace(-1, 1, CURVE_POINTS)
    b = float(schedule.effectiveness[k])
    pitch = turbine.pitch_min + effort_ramp(effort, schedule.overlap) / b
    slope = rotor_torque_gradient(turbine, speed, pitch, wind)[1]
    sigma = -slope / (turbine.inertia * b)
    share = effort_ramp_slope(effort, schedule.overlap)
    return float((1 - share * (1 - sigma)).min())


def _check(settings: EffortSettings) -> None:
    shares = ("bandwidth_growth", "torque_share", "integral_share", "partial_integral_share")
    for name in ("bandwidth", "partial_bandwidth", "speed_error", *shares):
        value = getattr(settings, name)
        if not 0 < value < 100:
            raise ModelError(f"{name} = {value!r} was given; a positive number is needed")
    low, high = settings.inertia
    if not 0 < low <= 1 <= high:
        raise ModelError(f"inertia {settings.inertia} was given; low <= 1 <= high, both positive")
