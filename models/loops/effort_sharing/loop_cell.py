"""The region on which the effort-sharing loop is enclosed, and one cell's enclosures."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import Interval

NOMINAL = Interval(Fraction(1), Fraction(1))


@dataclass(frozen=True, slots=True)
class LoopBox:
    """The region on which the family is valid, around the trim at the schedule wind.

    Attributes
    ----------
    speed_error : bound on |e| [rad/s].
    effort_lag : bound on |zeta| [rad/s^2].
    speed_signal : bound on |e - x| [rad/s]; the demanded effort is gamma times this.
    wind_share : bound on |v - v_s| over the cell's lower wind [-], up to which d is enclosed.
    """

    speed_error: Fraction
    effort_lag: Fraction
    speed_signal: Fraction
    wind_share: Fraction

    @property
    def directions(self) -> Floats:
        """(3, 3) rows h_i: (e, zeta, x) is in the box where |h_i' (e, zeta, x)| <= 1."""
        e, z, y = (float(b) for b in (self.speed_error, self.effort_lag, self.speed_signal))
        return np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]])


@dataclass(frozen=True, slots=True)
class LoopUncertainty:
    """The uncertainty that the family covers in addition to the nominal model.

    Attributes
    ----------
    inertia : the true inertia over the nominal one, e.g. [0.9, 1.1].
    frozen_wake : whether pitch effectiveness may reach the frozen-wake value.
    power_coefficient : the true c_P over the table's, e.g. [0.98, 1.02]; one factor for all pitch
        angles and tip-speed ratios.
    """

    inertia: Interval
    frozen_wake: bool
    power_coefficient: Interval = NOMINAL


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCell:
    """Enclosures of the loop's coefficients for schedule winds in one cell, moving at some rate.

    Attributes
    ----------
    wind : schedule winds [m/s];  wind_rate : |v_s'| [m/s^2] that is enclosed.
    stiffness : a [1/s];  loop_gain : Gamma [1/s];  lag_gain : S [-];  share_gain : Phi [1/s].
    lag_rate : T [1/s];  integral_rate : nu [1/s], a point.
    effectiveness_limit : b of the frozen wake [rad/s^2 per rad], by the law's table.
    residual : |r| [rad/s^2];  wind_gain : |d| [rad/s per m];  inertia_gain : largest kappa [-].
    effectiveness_slope : |b'/b| [1/m].
    reference_slope : |omega*' - kappa m mu f| [rad/s per m/s], the part of the moving reference
        that the torque's feed-forward does not compensate.
    lag_disturbance : |w_zeta| [rad/s^3], the part that the pitch lead does not compensate.
    speed : omega* [rad/s];  torque : reachable command [N m];  pitch : reachable angle [rad].
    pitch_rate : largest demanded rate (beta_ref - beta)/tau [rad/s], before the limit.
    """

    wind: Interval
    wind_rate: Fraction
    stiffness: Interval
    loop_gain: Interval
    lag_gain: Interval
    share_gain: Interval
    lag_rate: Interval
    integral_rate: Interval
    effectiveness_limit: Interval
    residual: Fraction
    wind_gain: Fraction
    inertia_gain: Fraction
    effectiveness_slope: Fraction
    reference_slope: Fraction
    lag_disturbance: Fraction
    speed: Interval
    torque: Interval
    pitch: Interval
    pitch_rate: Fraction
