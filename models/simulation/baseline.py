r"""The reference's own controller: torque by a curve over generator speed, pitch by a scheduled PI.

Both work on the filtered generator speed w_f, w_f' = c (n_g omega - w_f):

    region   generator speed          torque
    1        up to w_15               0
    1.5      w_15 to w_2              line from 0 to K w_2^2
    2        w_2 to w_25              K w_f^2
    2.5      w_25 to w_3              line from K w_25^2 to rated torque
    3        from w_3, or pitch >= 1 deg    constant power P / w_f

    beta_ref = G (K_P (w_f - w_ref) + K_I x),    x' = w_f - w_ref,    G = 1 / (1 + beta / beta_K)

with pitch >= 1 deg counted from the smallest pitch, and x held so that the integral part alone
stays inside the pitch range.  Nothing joins the two loops: near rated wind each goes its own way,
which is what the other laws are compared with.

Where it differs from the published source: the schedule G and the 1 deg rule read the measured
pitch, not the previous command; the rate limits are the plant's; everything runs at the
simulation's sampling instead of 1.25 ms; region 2.5 joins the curve at the published speed.

Source: Jonkman et al. (2009), NREL/TP-500-38060, ch. 7, and the controller source in the OpenFAST
5-MW deck, for the structure; the figures are ``turbine.baseline``.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim

# Pitch above its smallest from which torque is that of region 3 whatever the speed: OpenFAST 5-MW
# controller source, whose smallest pitch is 0.
REGION_3_PITCH = radians(1.0)


@dataclass(frozen=True, slots=True)
class BaselineLaw:
    """The reference's controller as a law.

    Attributes
    ----------
    turbine : its figures, with ``turbine.baseline``.

    Raises
    ------
    ModelError : a turbine without ``baseline``.
    """

    turbine: Turbine
    name: str = "baseline"
    state_names: tuple[str, ...] = (
        "filtered generator speed [rad/s]",
        "integral of speed error [rad]",
    )

    def __post_init__(self) -> None:
        _ = self.turbine.reference_controller  # Raises where there is none.

    def initial_state(self, wind: float) -> Floats:
        """Return (w_f, x) at the trim of this wind [m/s], cut-in to cut-out being held."""
        turbine, figures = self.turbine, self.turbine.reference_controller
        point = trim(turbine, min(max(wind, turbine.cut_in), turbine.cut_out))
        integral = point.pitch / (self._gain(point.pitch) * figures.integral_gain)
        return np.array([turbine.gear_ratio * point.rotor_speed, integral])

    def command(self, state: Floats, measurement: Measurement) -> Command:
        """Return torque [N m] and pitch reference [rad]; pitch stays inside its range."""
        turbine, figures = self.turbine, self.turbine.reference_controller
        speed, integral = float(state[0]), float(state[1])
        gain = self._gain(measurement.pitch)
        low, high = self._integral_range(gain)
        error = speed - turbine.gear_ratio * turbine.rated_rotor_speed
        limited_integral = min(max(integral, low), high)
        reference = gain * (
            figures.proportional_gain * error + figures.integral_gain * limited_integral
        )
        pitch = min(max(reference, turbine.pitch_min), turbine.pitch_max)
        return Command(self.torque(speed, measurement.pitch), pitch)

    def state_rate(self, state: Floats, measurement: Measurement) -> Floats:
        """Return (w_f', x'); x' is 0 where x is at an end of its range and would leave it."""
        turbine = self.turbine
        speed, integral = float(state[0]), float(state[1])
        error = speed - turbine.gear_ratio * turbine.rated_rotor_speed
        low, high = self._integral_range(self._gain(measurement.pitch))
        if (integral >= high and error > 0) or (integral <= low and error < 0):
            error = 0.0
        lag = turbine.speed_filter * (turbine.gear_ratio * measurement.rotor_speed - speed)
        return np.array([lag, error])

    def torque(self, speed: float, pitch: float) -> float:
        """Return the torque of the five regions [N m] at a generator speed [rad/s]."""
        figures, turbine = self.turbine.reference_controller, self.turbine
        constant = figures.optimal_torque_constant
        w_15, w_2 = figures.region_15_speed, figures.region_2_speed
        w_25, w_3 = figures.region_25_speed, figures.region_3_speed
        if speed >= w_3 or pitch >= turbine.pitch_min + REGION_3_PITCH:
            power = turbine.rated_torque * turbine.gear_ratio * turbine.rated_rotor_speed
            return min(power / max(speed, 1e-6), turbine.maximum_torque)
        if speed >= w_25:
            start = constant * w_25**2
            return start + (turbine.rated_torque - start) * (speed - w_25) / (w_3 - w_25)
        if speed >= w_2:
            return constant * speed**2
        if speed > w_15:
            return constant * w_2**2 * (speed - w_15) / (w_2 - w_15)
        return 0.0

    def _gain(self, pitch: float) -> float:
        return 1 / (1 + max(pitch, 0.0) / self.turbine.reference_controller.schedule_pitch)

    def _integral_range(self, gain: float) -> tuple[float, float]:
        scale = gain * self.turbine.reference_controller.integral_gain
        return self.turbine.pitch_min / scale, self.turbine.pitch_max / scale
