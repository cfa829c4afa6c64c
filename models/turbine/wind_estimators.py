r"""Two other estimators of the wind from the rotor's balance, to compare the observer with.

    omega' = (T_r(omega, beta, v) - n_g T) / J

Extended Kalman filter, in continuous time: v' is white noise of density q [m^2/s^3], the measured
speed has white noise of density r [rad^2/s].  With d = dT_r/dv / J, a = dT_r/domega / J and the
covariance P,

    omegahat' = (T_r(omegahat, beta, vhat) - n_g T) / J + P_11 / r (omega - omegahat)
    vhat'     = P_12 / r (omega - omegahat),        P' = F P + P F' + diag(0, q) - P C' C P / r.

Immersion and invariance: vhat = x + gamma omega with

    x' = -gamma (T_r(omega, beta, vhat) - n_g T) / J.

At constant wind and pitch

    (v - vhat)' = -gamma (T_r(omega, beta, v) - T_r(omega, beta, vhat)) / J,

so the error shrinks at all times where T_r rises with the wind between vhat and v.

Sources: Soltani, Knudsen, Svenstrup, Wisniewski, Brath, Ortega, Johnson (2013), "Estimation of
rotor effective wind speed: a comparison", IEEE Trans. Control Systems Technology 21 (both);
Ortega, Mancilla-David, Jaramillo (2013), "A globally convergent wind speed estimator for wind
turbine systems", Int. J. Adaptive Control and Signal Processing 27 (the second).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.splines.scalar_surface import scalar_surface
from takagi.models.turbine.data import Turbine

# Of the finite differences that linearise the rotor's torque [rad/s, m/s].
SPEED_STEP, WIND_STEP = 1e-3, 1e-2
# The covariance takes at least this dT_r/dv / J [1/s/m]: it stays finite where the rotor stalls.
LEAST_SLOPE = 1e-3


@dataclass(frozen=True, slots=True)
class KalmanWindFilter:
    """The extended Kalman filter, with state (omegahat, vhat, P_11, P_12, P_22).

    Attributes
    ----------
    wind_noise : q, density of v' [m^2/s^3];  speed_noise : r, density of the speed's [rad^2/s].
        Only q / r counts for the estimate.

    Raises
    ------
    ModelError : a density that is not positive and finite.
    """

    turbine: Turbine
    wind_noise: float
    speed_noise: float = 1e-4

    def __post_init__(self) -> None:
        _check_positive(wind_noise=self.wind_noise, speed_noise=self.speed_noise)

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        """Return the guess, with the covariance that is at rest there for pitch 0 and a = 0."""
        wind = _limited(self.turbine, wind)
        slope = self._slopes(rotor_speed, 0.0, wind)[1]
        q, r = self.wind_noise, self.speed_noise
        cross = math.sqrt(q * r)
        first = math.sqrt(2 * slope * r * cross)
        return np.array([rotor_speed, wind, first, cross, first * cross / (r * slope)])

    def wind_estimate(self, state: Floats) -> float:
        """Return vhat [m/s], held between half of cut-in and 1.5 times cut-out."""
        return _limited(self.turbine, float(state[1]))

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        """Return the state's derivative; zero for a reading that is not a finite number."""
        if not math.isfinite(rotor_speed + pitch + torque):
            return np.zeros(5)
        turbine, wind = self.turbine, self.wind_estimate(state)
        speed, _, p11, p12, p22 = state.tolist()
        balance = _torque(turbine, speed, pitch, wind) - turbine.gear_ratio * torque
        a, d = self._slopes(speed, pitch, wind)
        error, r = rotor_speed - speed, self.speed_noise
        return np.array(
            [
                balance / turbine.inertia + p11 / r * error,
                _within(turbine, float(state[1]), p12 / r * error),
                2 * (a * p11 + d * p12) - p11 * p11 / r,
                a * p12 + d * p22 - p11 * p12 / r,
                self.wind_noise - p12 * p12 / r,
            ]
        )

    def _slopes(self, speed: float, pitch: float, wind: float) -> tuple[float, float]:
        """Return a and d [1/s, 1/s/m] by central differences; d is at least LEAST_SLOPE."""
        turbine = self.turbine
        by_speed = _torque(turbine, speed + SPEED_STEP, pitch, wind) - _torque(
            turbine, speed - SPEED_STEP, pitch, wind
        )
        by_wind = _torque(turbine, speed, pitch, wind + WIND_STEP) - _torque(
            turbine, speed, pitch, wind - WIND_STEP
        )
        slope = by_wind / (2 * WIND_STEP * turbine.inertia)
        return by_speed / (2 * SPEED_STEP * turbine.inertia), max(slope, LEAST_SLOPE)


@dataclass(frozen=True, slots=True)
class ImmersionInvarianceEstimator:
    """The immersion-and-invariance estimator, with state (x + gamma omega_f, omega_f).

    The estimate holds the measured speed as it is; here that speed passes a first-order filter
    omega_f first, so that the estimate is a function of the state alone.

    Attributes
    ----------
    gain : gamma [m];  speed_lag : of the filter [s], at least the step of whoever runs it.

    Raises
    ------
    ModelError : a gain or lag that is not positive and finite.
    """

    turbine: Turbine
    gain: float
    speed_lag: float = 0.05

    def __post_init__(self) -> None:
        _check_positive(gain=self.gain, speed_lag=self.speed_lag)

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        """Return the state for a measured speed and a first guess of the wind."""
        return np.array([_limited(self.turbine, wind), rotor_speed])

    def wind_estimate(self, state: Floats) -> float:
        """Return vhat [m/s], held between half of cut-in and 1.5 times cut-out."""
        return _limited(self.turbine, float(state[0]))

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        """Return the state's derivative; zero for a reading that is not a finite number."""
        if not math.isfinite(rotor_speed + pitch + torque):
            return np.zeros(2)
        turbine, wind = self.turbine, self.wind_estimate(state)
        speed = float(state[1])
        expected = _torque(turbine, speed, pitch, wind) - turbine.gear_ratio * torque
        acceleration = (rotor_speed - speed) / self.speed_lag
        rate = self.gain * (acceleration - expected / turbine.inertia)
        return np.array([_within(turbine, float(state[0]), rate), acceleration])


def _check_positive(**numbers: float) -> None:
    for name, value in numbers.items():
        if not (math.isfinite(value) and value > 0):
            raise ModelError(f"{name} = {value!r} was given; it must be positive and finite")


def _limits(turbine: Turbine) -> tuple[float, float]:
    return 0.5 * turbine.cut_in, 1.5 * turbine.cut_out


def _limited(turbine: Turbine, wind: float) -> float:
    low, high = _limits(turbine)
    return min(max(wind, low), high)


def _within(turbine: Turbine, wind: float, rate: float) -> float:
    """Return the rate, or zero where it would push the wind further past a limit."""
    low, high = _limits(turbine)
    return 0.0 if (wind <= low and rate < 0) or (wind >= high and rate > 0) else rate


def _torque(turbine: Turbine, speed: float, pitch: float, wind: float) -> float:
    """Return T_r [N m]; beyond the table's edge its coefficient is that of the edge."""
    c_q = scalar_surface(turbine.torque)(speed * turbine.rotor_radius / wind, pitch)
    return turbine.torque_constant * wind * wind * c_q
