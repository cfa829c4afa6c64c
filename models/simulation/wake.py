"""The induced wind at rest, where a simulation starts; in time it is in ``equations``."""

from __future__ import annotations

from takagi.models.turbine.aerodynamics import rotor_thrust
from takagi.models.turbine.data import Turbine


def steady_induced_wind(turbine: Turbine, speed: float, pitch: float, wind: float) -> float:
    """Return w = k_a a(c_T) v [m/s] at rotor speed [rad/s], pitch [rad] and wind [m/s]."""
    from takagi.models.simulation.equations import LEAST_FLOW, induction

    scale = turbine.torque_constant / turbine.rotor_radius * wind**2
    thrust = float(rotor_thrust(turbine, speed, pitch, wind, clip=True))
    share = turbine.wake.induction * induction(thrust / scale)[0]
    return min(share, 1.0 - LEAST_FLOW) * wind
