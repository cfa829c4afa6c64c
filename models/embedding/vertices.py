"""Corners of an interval family: the matrices whose hull contains every loop of a cell.

The loop's matrix is affine in each coefficient when the others are held, so over a box of
coefficients it lies in the convex hull of its corners; the disturbance likewise.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from takagi.models.embedding.coherent import LoopCell
from takagi.models.enclosure.interval import Interval

__all__ = ["LoopVertices", "loop_vertices"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LoopVertices:
    """Corners of one cell.

    Attributes
    ----------
    A : (N, 3, 3) in (e [rad/s], zeta [rad/s^2], x [rad/s]).
    residual : (N, 3) disturbance of the tables' residual;  per_wind_error : (N, 3) per m/s of
    |v - v_s|;  per_wind_rate : (N, 3) per m/s^2 of |v_s'|.  Each of them at a corner of the signs.
    """

    A: Floats
    residual: Floats
    per_wind_error: Floats
    per_wind_rate: Floats


def loop_vertices(cell: LoopCell) -> LoopVertices:
    """Return the corners of the cell's coefficients, with both relative signs of (w_e, w_zeta).

    Opposite signs of both give the mirrored inequality, so one sign of w_e suffices.
    """
    nu = float(cell.integral_rate.lower)
    residual = float(cell.inertia_gain * cell.residual)
    error = float(cell.inertia_gain * cell.wind_gain)
    slope, lag = float(cell.reference_slope), float(cell.lag_slope)
    A, by_residual, by_error, by_rate = [], [], [], []
    corners = product(
        _ends(cell.stiffness),
        _ends(cell.loop_gain),
        _ends(cell.lag_gain),
        _ends(cell.share_gain),
        _ends(cell.lag_rate),
        (1.0, -1.0),
    )
    for a, gamma, s, phi, rate, sign in corners:
        A.append(
            [
                [a - gamma, s, gamma],
                [phi * (a - gamma + nu), phi * s - rate, phi * gamma],
                [-nu, 0.0, 0.0],
            ]
        )
        by_residual.append([residual, phi * residual, 0.0])
        by_error.append([error, phi * error, 0.0])
        by_rate.append([slope, phi * slope + sign * lag, 0.0])
    return LoopVertices(np.array(A), np.array(by_residual), np.array(by_error), np.array(by_rate))


def _ends(interval: Interval) -> tuple[float, ...]:
    low, high = float(interval.lower), float(interval.upper)
    return (low,) if low == high else (low, high)
