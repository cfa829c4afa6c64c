"""A bicubic spline as one polynomial per patch, evaluated at many points at once.

    s(x, y) = sum_pq a_pq (x - x_i)^p (y - y_j)^q      on [x_i, x_{i+1}] x [y_j, y_{j+1}]

The coefficients a come from the B-spline's by scipy.  A point outside the table gets the value at
the nearest edge point; ``inside`` detects it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline

from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError

DEGREE = 3


@dataclass(frozen=True, slots=True, eq=False)
class PatchAxis:
    """The breakpoints along one axis, and the piece that begins in each of its equal buckets.

    Buckets are no wider than the narrowest piece, so a point lies in its bucket's piece or in the
    next one. This is faster than a search.
    """

    breaks: Floats
    pieces: Indices
    per_unit: float

    @classmethod
    def of(cls, breaks: Floats) -> PatchAxis:
        """Return the axis of increasing ends."""
        count = int(np.ceil((breaks[-1] - breaks[0]) / np.diff(breaks).min())) + 1
        starts = breaks[0] + np.arange(count) * (breaks[-1] - breaks[0]) / (count - 1)
        pieces = np.searchsorted(breaks[1:-1], starts, side="right")
        return cls(breaks, pieces, float((count - 1) / (breaks[-1] - breaks[0])))

    def placed(self, points: Floats) -> tuple[Indices, Floats]:
        """Return each point's piece, limited to the axis, and its offset from the piece's start."""
        held = np.minimum(np.maximum(points, self.breaks[0]), self.breaks[-1])
        bucket = ((held - self.breaks[0]) * self.per_unit).astype(np.intp)
        piece = self.pieces[bucket]
        later = np.minimum(piece + 1, len(self.breaks) - 2)
        piece = np.where(held >= self.breaks[later], later, piece)
        return piece, held - self.breaks[piece]


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """The spline's pieces.

    Attributes
    ----------
    x, y : the two axes.
    coefficients : (16, patches): row 4 p + q holds a_{3-p, 3-q}, patches row by row.
    """

    x: PatchAxis
    y: PatchAxis
    coefficients: Floats

    def inside(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """Return which points lie in the table."""
        x_in = (x >= self.x.breaks[0]) & (x <= self.x.breaks[-1])
        return np.asarray(x_in & (y >= self.y.breaks[0]) & (y <= self.y.breaks[-1]))

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Return s at (n,) points."""
        i, x = self.x.placed(x)
        j, y = self.y.placed(y)
        a = self.coefficients.take(i * (len(self.y.breaks) - 1) + j, axis=1)
        rows = ((a[0::4] * y + a[1::4]) * y + a[2::4]) * y + a[3::4]
        return np.asarray(((rows[0] * x + rows[1]) * x + rows[2]) * x + rows[3])


def spline_patches(x_knots: ArrayLike, y_knots: ArrayLike, coefficients: ArrayLike) -> Patches:
    """Return the pieces of sum_ij c_ij N_i(x) N_j(y) with cubic B-splines N.

    Raises
    ------
    ModelError : numbers of knots and coefficients that do not fit.
    """
    x, y = np.asarray(x_knots, dtype=np.float64), np.asarray(y_knots, dtype=np.float64)
    c = np.asarray(coefficients, dtype=np.float64)
    expected = (len(x) - DEGREE - 1, len(y) - DEGREE - 1)
    if c.shape != expected or min(expected) <= DEGREE:
        raise ModelError(
            f"the torque surface has coefficients of shape {c.shape}; its knots ask for {expected}"
        )
    along_x = _pieces(x, c)  # (4, pieces in x, ny)
    both = _pieces(y, np.moveaxis(along_x, 2, 0))  # (4, pieces in y, 4, pieces in x)
    ordered = np.transpose(both, (2, 0, 3, 1))
    axes = PatchAxis.of(x[DEGREE:-DEGREE]), PatchAxis.of(y[DEGREE:-DEGREE])
    return Patches(*axes, np.ascontiguousarray(ordered.reshape(16, -1)))


def _pieces(knots: Floats, c: Floats) -> Floats:
    """Return polynomial coefficients, highest power first, of a cubic spline along axis 0 of c."""
    spline, starts = BSpline(knots, c, DEGREE), knots[DEGREE : -DEGREE - 1]
    orders = range(DEGREE, -1, -1)
    return np.stack([spline(starts, nu=order) / math.factorial(order) for order in orders])
