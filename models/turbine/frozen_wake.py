r"""The frozen wake from the coefficient tables, for a turbine of which nothing is published.

Momentum theory slows the wind at the rotor by the induction: u = v (1 - k_a a(c_T)).  Pitch acts
first at constant u, and the wake answers later.  The table's slopes are those with the wake in
equilibrium; the slope at constant u follows from them:

    dP/dbeta = omega (T_beta - T_v u_beta / u_v)              [W/rad]
    u_beta   = -k_a a' v c_T,beta
    u_v      = 1 - k_a a + k_a a' lambda c_T,lambda           lambda = omega R / v

at rated speed omega and the trim pitch, with the slopes T_beta, T_v of the torque at constant
pitch and speed.  k_a is the file's ``wake.induction`` or that of ``DiscWake``, and

    a(c_T) = (1 - sqrt(1 - c_T)) / 2, beyond c_T = 8/9 its tangent there.

c_T is linear between the table's entries, in tip-speed ratio and in pitch, and held at its edges;
its slopes are differences over +-1/4 and +-1/50 rad.  The winds are the multiples of 1/2 m/s above
rated wind, and cut-out.  With k_a of its file the rule meets the published column of the NREL 5-MW
turbine within 4 % from 13 m/s on, and within 10 % below.

``takagi.certificates.checker.files.turbine_file`` computes the same in exact numbers.

Source: momentum theory of the actuator disc, Burton et al. (2011), Wind Energy Handbook, ch. 3.
"""

from __future__ import annotations

from math import floor, sqrt

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.files.csv_table import CoefficientTable
from takagi.models.turbine.aerodynamics import rotor_torque_gradient
from takagi.models.turbine.data import FrozenWake, Turbine
from takagi.models.turbine.trim import rated_wind, trim

WIND_STEP = 0.5
RATIO_STEP, PITCH_STEP = 0.25, 0.02
LAST_MOMENTUM = 8 / 9


def frozen_wake_by_tables(turbine: Turbine, thrust: CoefficientTable) -> FrozenWake:
    """Return the column of dP/dbeta with the induction held, by the rule of this module.

    Parameters
    ----------
    turbine : its own frozen wake is not read.
    thrust : the table of c_T, as its file has it.

    Raises
    ------
    ModelError : no trim, or a wind at which pitching up does not lower power by this rule.
    """
    first, last = rated_wind(turbine), turbine.cut_out
    steps = range(floor(first / WIND_STEP) + 1, floor(last / WIND_STEP) + 1)
    winds = sorted({*(WIND_STEP * step for step in steps), last})
    points = [_point(turbine, thrust, wind) for wind in winds]
    pitch, sensitivity = zip(*points, strict=True)
    source = (
        "computed from the tables by momentum theory with the induction held, k_a = "
        f"{turbine.wake.induction:g}: nothing was stated"
    )
    return FrozenWake(tuple(winds), pitch, sensitivity, source)


def _point(turbine: Turbine, thrust: CoefficientTable, wind: float) -> tuple[float, float]:
    """Return trim pitch [rad] and dP/dbeta [W/rad] at one wind."""
    speed, pitch, wake = turbine.rated_rotor_speed, trim(turbine, wind).pitch, turbine.wake
    ratio = speed * turbine.rotor_radius / wind
    _, by_pitch, by_wind = (float(s) for s in rotor_torque_gradient(turbine, speed, pitch, wind))
    a, slope = _induction(_thrust(thrust, ratio, pitch))
    loss = wake.induction * slope
    flow = 1 - wake.induction * a + loss * ratio * _slope(thrust, ratio, pitch, RATIO_STEP, 0)
    slowed = loss * wind * _slope(thrust, ratio, pitch, 0, PITCH_STEP)
    sensitivity = speed * (by_pitch + by_wind * slowed / flow) if flow > 0 else 0.0
    if sensitivity >= 0:
        raise ModelError(
            f"{turbine.name}: no frozen wake was stated, and the tables give none at {wind:.6g} "
            f"m/s (dP/dpitch {sensitivity:.4g} W/rad, 1 - k_a a {flow:.4g}; both signs must be the "
            "other): state [frozen_wake] with wind and factor, or correct c_T there"
        )
    return pitch, sensitivity


def _thrust(table: CoefficientTable, ratio: float, pitch: float) -> float:
    along = [np.interp(pitch, table.pitch, row) for row in table.values]
    return float(np.interp(ratio, table.tip_speed_ratio, along))


def _slope(
    table: CoefficientTable, ratio: float, pitch: float, by_ratio: float, by_pitch: float
) -> float:
    above = _thrust(table, ratio + by_ratio, pitch + by_pitch)
    below = _thrust(table, ratio - by_ratio, pitch - by_pitch)
    return (above - below) / (2 * (by_ratio + by_pitch))


def _induction(thrust_coefficient: float) -> tuple[float, float]:
    """Return a(c_T) and its slope."""
    if thrust_coefficient > LAST_MOMENTUM:
        return 1 / 3 + 0.75 * (thrust_coefficient - LAST_MOMENTUM), 0.75
    root = sqrt(1 - thrust_coefficient)
    return (1 - root) / 2, 0.25 / root
