r"""What a wake that needs time adds to rotor torque when the blades pitch.

A quasi-steady coefficient table answers a pitch step with the wake's new equilibrium at once; the
real wake holds its induction for a few seconds, and the torque first changes by much more:

    T_r = T_eq(omega, beta, v) + g(v) (beta - beta_w),       beta_w' = (beta - beta_w) / tau_w
    g(v) = S_frozen(v) / omega_r - dT_eq/dbeta at the trim of v
    tau_w = 1.1 / (1 - 1.3 a) R / v,       a = (1 - sqrt(1 - c_T)) / 2, at most 0.5

A fast pitch movement at trim thus meets the published frozen-wake sensitivity S_frozen, a slow one
the table's, and every steady state is the table's own.  Between the published winds g is linear,
outside it is held.  Only the pitch path of torque is covered: there are no published figures for
thrust or for the answer to wind and speed, and those stay in equilibrium.

Source: S_frozen as in the turbine's file; tau_w: Oye's first time constant, in Hansen (2008),
Aerodynamics of Wind Turbines, ch. 9.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import lru_cache
from math import sqrt

from takagi.models.turbine.aerodynamics import rotor_torque_gradient
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim

LARGEST_INDUCTION = 0.5


@lru_cache(maxsize=16)
def excess_sensitivity(turbine: Turbine) -> Callable[[float], float]:
    """Return g(v) [N m/rad] as a function of one wind [m/s].

    Source: see the head of this file.
    """
    winds = list(turbine.frozen_wake.wind)
    values = []
    for wind, power in zip(winds, turbine.frozen_wake.power_sensitivity, strict=True):
        point = trim(turbine, wind)
        by_pitch = rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, wind)[1]
        values.append(power / turbine.rated_rotor_speed - float(by_pitch))

    def interpolate(wind: float) -> float:
        k = min(max(bisect_right(winds, wind), 1), len(winds) - 1)
        share = (wind - winds[k - 1]) / (winds[k] - winds[k - 1])
        share = min(max(share, 0.0), 1.0)
        return values[k - 1] + share * (values[k] - values[k - 1])

    return interpolate


def wake_time_constant(thrust_coefficient: float, rotor_radius: float, wind: float) -> float:
    """Return tau_w = 1.1 / (1 - 1.3 a) R / v [s] with a from c_T = 4 a (1 - a).

    Source: Oye, in Hansen (2008), Aerodynamics of Wind Turbines, ch. 9.
    """
    induction = (1 - sqrt(max(1 - thrust_coefficient, 0.0))) / 2
    return 1.1 / (1 - 1.3 * min(induction, LARGEST_INDUCTION)) * rotor_radius / wind
