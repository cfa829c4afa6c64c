r"""Rotor torque, power and thrust from the coefficient surfaces; vectorised over arrays.

    lambda = omega R / v
    T_r = (rho pi R^3 / 2) v^2 c_Q(lambda, beta)            [N m], low-speed side
    P   = omega T_r                                         [W], mechanical
    F   = (rho pi R^2 / 2) v^2 c_T(lambda, beta)            [N]

Outside the table these functions raise ``ModelError``.  ``clip=True`` holds the *coefficient* at
the table's edge instead (lambda and beta are moved there): a simulation that touches the edge then
goes on, with a torque that is continuous and no longer a figure of the rotor.

Source: theory of the ideal actuator disc; Burton et al. (2011), Wind Energy Handbook, ch. 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine


def tip_speed_ratio(turbine: Turbine, rotor_speed: ArrayLike, wind: ArrayLike) -> Floats:
    """Return lambda = omega R / v [-]; ModelError where the wind is not above 0."""
    v = np.asarray(wind, dtype=np.float64)
    if not np.all(v > 0):
        raise ModelError(f"wind {np.min(v):.9g} m/s was given; a wind above 0 is needed")
    omega = np.asarray(rotor_speed, dtype=np.float64)
    return np.asarray(omega * turbine.rotor_radius / v, dtype=np.float64)


def rotor_torque(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> Floats:
    """Return T_r = (rho pi R^3 / 2) v^2 c_Q(lambda, beta) [N m], low-speed side.

    Parameters
    ----------
    rotor_speed [rad/s], pitch [rad], wind [m/s] : numbers or arrays that broadcast.
    clip : hold the coefficient at the table's edge instead of raising.

    Raises
    ------
    ModelError : a point outside the table (with clip=False), or wind <= 0.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    c_q = turbine.torque(lam, pitch, clip=clip)
    return np.asarray(turbine.torque_constant * v**2 * c_q, dtype=np.float64)


def rotor_torque_gradient(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> tuple[Floats, Floats, Floats]:
    """Return (dT_r/d omega, dT_r/d beta, dT_r/d v), exact derivatives of the spline.

    With k = rho pi R^3 / 2:  k R v c_Q,lambda  [N m s/rad];  k v^2 c_Q,beta  [N m/rad];
    k v (2 c_Q - lambda c_Q,lambda)  [N s].

    Parameters and errors as for ``rotor_torque``.  With clip=True the derivatives are those at
    the table's edge, not of the held coefficient.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    if clip:
        lam = np.clip(lam, *turbine.torque.x_range)
    k = turbine.torque_constant
    c_q = turbine.torque(lam, pitch, clip=clip)
    by_lambda = turbine.torque(lam, pitch, dx=1, clip=clip)
    by_pitch = turbine.torque(lam, pitch, dy=1, clip=clip)
    return (
        np.asarray(k * turbine.rotor_radius * v * by_lambda, dtype=np.float64),
        np.asarray(k * v**2 * by_pitch, dtype=np.float64),
        np.asarray(k * v * (2 * c_q - lam * by_lambda), dtype=np.float64),
    )


def rotor_thrust(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> Floats:
    """Return F = (rho pi R^2 / 2) v^2 c_T(lambda, beta) [N].

    Parameters and errors as for ``rotor_torque``.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    c_t = turbine.thrust(lam, pitch, clip=clip)
    factor = turbine.torque_constant / turbine.rotor_radius
    return np.asarray(factor * v**2 * c_t, dtype=np.float64)
