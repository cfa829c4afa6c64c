r"""The effort-sharing loop in one cell of winds: its region, its coefficients' ranges, its corners.

The loop's matrix is affine in each coefficient when the others are held, so over a box of
coefficients it lies in the convex hull of its corners; the disturbance likewise.  The checker's
``turbine.effort_sharing.loop_claim`` writes the loop out, in the coordinates (e, zeta, x).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

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
    torque : reachable command [N m];  pitch : reachable angle [rad].
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
    torque: Interval
    pitch: Interval
    pitch_rate: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class LoopVertices:
    """Corners of one cell.

    Attributes
    ----------
    A : (N, 3, 3) in (e [rad/s], zeta [rad/s^2], x [rad/s]), with a schedule wind that moves at up
        to the cell's rate.
    at_rest : (M, 3, 3) with a constant schedule wind.
    fixed : (N, 3) disturbance of the tables' residual and of the cell's wind rate;
    per_wind_error : (N, 3) per m/s of |v - v_s|.  Each of them at a corner of the signs.
    """

    A: Floats
    at_rest: Floats
    fixed: Floats
    per_wind_error: Floats


def loop_vertices(cell: LoopCell) -> LoopVertices:
    """Return the corners of the cell's coefficients, with both relative signs of (w_e, w_zeta).

    Opposite signs of both give the mirrored inequality, so one sign of w_e suffices. If w_zeta is
    zero there is only one sign.  T - (b'/b) v_s' is one coefficient, in a wider range than T.
    """
    rate = float(cell.wind_rate)
    steady = float(cell.inertia_gain * cell.residual) + float(cell.reference_slope) * rate
    error = float(cell.inertia_gain * cell.wind_gain)
    lag = float(cell.lag_disturbance)
    turning = cell.effectiveness_slope * cell.wind_rate
    moving = Interval(cell.lag_rate.lower - turning, cell.lag_rate.upper + turning)
    A, fixed, by_error = [], [], []
    for matrix, phi in _matrices(cell, moving):
        for sign in (1.0, -1.0) if lag else (1.0,):
            A.append(matrix)
            fixed.append([steady, phi * steady + sign * lag, 0.0])
            by_error.append([error, phi * error, 0.0])
    at_rest = [matrix for matrix, _ in _matrices(cell, cell.lag_rate)]
    return LoopVertices(np.array(A), np.array(at_rest), np.array(fixed), np.array(by_error))


def _matrices(cell: LoopCell, lag_rate: Interval) -> Iterator[tuple[list[list[float]], float]]:
    """Yield the matrix at each corner, and its Phi."""
    nu = float(cell.integral_rate.lower)
    ranges = (cell.stiffness, cell.loop_gain, cell.lag_gain, cell.share_gain, lag_rate)
    for a, gamma, s, phi, rate in product(*map(_ends, ranges)):
        yield (
            [
                [a - gamma, s, gamma],
                [phi * (a - gamma + nu), phi * s - rate, phi * gamma],
                [-nu, 0.0, 0.0],
            ],
            phi,
        )


def _ends(interval: Interval) -> tuple[float, ...]:
    low, high = float(interval.lower), float(interval.upper)
    return (low,) if low == high else (low, high)
