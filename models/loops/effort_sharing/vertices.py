"""Corners of an interval family: the matrices whose hull contains every loop of a cell.

The loop's matrix is affine in each coefficient when the others are held, so over a box of
coefficients it lies in the convex hull of its corners; the disturbance likewise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import Interval
from takagi.models.loops.effort_sharing.loop_cell import LoopCell


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
