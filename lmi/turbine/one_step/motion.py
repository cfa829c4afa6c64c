r"""Standard deviations of pitch rate and tower speed in turbulence: a linear estimate, no bound.

The one-step design compares gains by these numbers; no certificate uses them.  At the middle of
each wind cell the law and the turbine are linearised about the trim by central differences.  The
model includes the tower's fore-aft mode,

    m y'' = F(omega, beta, v - y') - F_0 - c y' - k y ,

and a wind v' = -(v - v_0) / T + sqrt(2 / T) n of standard deviation 1 m/s, where T = L / v_0 and n
is white noise of unit intensity.  The law's wind estimate is the wind itself.  The covariance X of
the state solves A X + X A' + B B' = 0.  The objective uses the mean over the wind range.

Source: Brogan (1991), Modern Control Theory, section 11.5 (covariance of a linear system);
L = 8.1 * 42 m is the Kaimal length of the longitudinal component in IEC 61400-1 ed. 3, Annex B
(recalled); the first-order wind has the same spectrum at low frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Measurement
from takagi.models.turbine.aerodynamics import rotor_thrust, rotor_torque
from takagi.models.turbine.data import Turbine

TURBULENCE_LENGTH = 8.1 * 42.0  # m
# Steps of the central differences for rotor speed, pitch, integral, schedule wind, tower position,
# tower speed and wind, each small beside the range over which the loop's slopes change.
STEPS = np.array([1e-4, 1e-5, 1e-4, 1e-3, 1e-3, 1e-3, 1e-3])


@dataclass(frozen=True, slots=True, eq=False)
class PitchAndTowerMotion:
    """Standard deviations in each wind cell, for a wind of standard deviation 1 m/s.

    All three are inf in a cell where the linear loop is not stable.

    Attributes
    ----------
    speed : (K - 1,) of omega - omega* [rad/s];  pitch_rate : (K - 1,) [rad/s];  tower_speed :
        (K - 1,) of y' [m/s].
    """

    speed: Floats
    pitch_rate: Floats
    tower_speed: Floats


def motion(
    turbine: Turbine, law: EffortSharingLaw, cells: range | None = None
) -> PitchAndTowerMotion:
    """Return the standard deviations in the given wind cells; in all cells for ``None``."""
    nodes = law.schedule.wind
    chosen = range(len(nodes) - 1) if cells is None else cells
    rows = [_deviations(turbine, law, (nodes[k] + nodes[k + 1]) / 2) for k in chosen]
    speed, pitch, tower = np.array(rows, dtype=np.float64).reshape(-1, 3).T
    return PitchAndTowerMotion(speed, pitch, tower)


def _deviations(turbine: Turbine, law: EffortSharingLaw, wind: float) -> tuple[float, float, float]:
    at = np.array([_between(law, law.schedule.rotor_speed, wind), 0, 0, wind, 0, 0, wind])
    at[1] = law.schedule.pitch(wind, turbine)
    thrust = float(rotor_thrust(turbine, at[0], at[1], wind))
    rates = _loop(turbine, law, thrust)
    jacobian = np.empty((7, 7))
    for column, step in enumerate(STEPS):
        beside = np.zeros(7)
        beside[column] = step
        jacobian[:, column] = (rates(at + beside) - rates(at - beside)) / (2 * step)
    # 1 / T of the first-order wind: turbulence passes the rotor with the mean wind speed.
    pace = wind / TURBULENCE_LENGTH
    # The wind filters white noise; the loop does not act on it.
    jacobian[6] = 0.0
    jacobian[6, 6] = -pace
    # The Lyapunov equation of an unstable loop has a solution too, but it is no covariance.
    if np.linalg.eigvals(jacobian).real.max() >= 0:
        return np.inf, np.inf, np.inf
    noise = np.zeros((7, 7))
    noise[6, 6] = 2 * pace
    X = solve_continuous_lyapunov(jacobian, -noise)
    node = min(int(np.searchsorted(law.schedule.wind, wind)) - 1, len(law.schedule.wind) - 2)
    slope = np.diff(law.schedule.rotor_speed)[node] / np.diff(law.schedule.wind)[node]
    # omega* moves with the schedule wind: the error is omega - (d omega* / d v_s) v_s.
    error = np.eye(7)[0] - slope * np.eye(7)[3]
    return tuple(float(np.sqrt(max(h @ X @ h, 0.0))) for h in (error, jacobian[1], np.eye(7)[5]))  # type: ignore[return-value]


def _loop(turbine: Turbine, law: EffortSharingLaw, thrust: float) -> Callable[[Floats], Floats]:
    """Return the function z -> dz/dt of z = (omega, beta, x, v_s, y, y', v).

    The rate of the wind is 0 here; the caller adds the first-order wind.
    """

    def rates(z: Floats) -> Floats:
        omega, beta, x, scheduled, y, moving, wind = z
        # The rotor meets the wind relative to the tower top, which is the tower's aerodynamic
        # damping.
        seen = wind - moving
        measured = Measurement(omega, beta, wind)
        state = np.array([x, scheduled])
        command = law.command(state, measured)
        torque = float(rotor_torque(turbine, omega, beta, seen))
        push = float(rotor_thrust(turbine, omega, beta, seen)) - thrust
        integral, follow = law.state_rate(state, measured)
        return np.array(
            [
                (torque - turbine.gear_ratio * command.torque) / turbine.inertia,
                (command.pitch - beta) / turbine.pitch_time_constant,
                integral,
                follow,
                moving,
                (push - turbine.tower_damping * moving - turbine.tower_stiffness * y)
                / turbine.tower_mass,
                0.0,
            ]
        )

    return rates


def _between(law: EffortSharingLaw, column: Floats, wind: float) -> float:
    return float(np.interp(wind, law.schedule.wind, column))
