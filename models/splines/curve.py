"""Interpolating cubic spline of one argument, with exact values and rigorous ranges.

The spline is *defined* by the shortest decimals of its knots and coefficients; floats evaluate it
to rounding, and ``bounds`` encloses it in exact arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from math import lcm

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.splines.exact_spline import (
    DEGREE,
    MAX_ORDER,
    ExactSpline,
    exact_bounds,
    exact_spline,
    points_inside,
    require_inside,
)

# A curve is treated as a surface that does not depend on y: the y direction has one span [0, 1] and
# four equal coefficients.
FLAT_KNOTS = tuple(Fraction(k) for k in (0, 0, 0, 0, 1, 1, 1, 1))
DIGITS = 14  # of the coefficients, counted from the largest
ORIGIN = Interval(Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Cubic spline s(x) = sum_i c_i N_i(x).

    Attributes
    ----------
    knots : full knot vector, (n + 4,); each float stands for its shortest decimal.
    coefficients : (n,); likewise.
    name, x_name : words for messages, e.g. ``"friction"``, ``"speed [rad/s]"``.

    Raises
    ------
    ModelError : sizes that do not fit, knots that do not increase, a number that is not finite.
    """

    knots: Floats
    coefficients: Floats
    name: str = "curve"
    x_name: str = "x"
    _spline: BSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("knots", "coefficients"):
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.ndim != 1 or not np.all(np.isfinite(array)):
                raise ModelError(f"{self.name}: {name} must be a row of finite numbers")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        coefficient_count = len(self.knots) - DEGREE - 1
        if coefficient_count < DEGREE + 1 or len(self.coefficients) != coefficient_count:
            raise ModelError(
                f"{self.name}: {len(self.coefficients)} coefficients for {len(self.knots)} knots; "
                f"{max(coefficient_count, DEGREE + 1)} are needed, at least {DEGREE + 1}"
            )
        steps = np.diff(self.knots)
        if np.any(steps < 0) or not np.all(steps[DEGREE : len(steps) - DEGREE] > 0):
            raise ModelError(f"{self.name}: knots must increase, inner knots strictly")
        object.__setattr__(self, "_spline", BSpline(self.knots, self.coefficients, DEGREE))

    @property
    def x_range(self) -> tuple[float, float]:
        """Smallest and largest x of the table."""
        return float(self.knots[DEGREE]), float(self.knots[-DEGREE - 1])

    def __call__(self, x: ArrayLike, dx: int = 0, *, clip: bool = False) -> Floats:
        """Return d^dx s / dx^dx at the points; orders 0, 1 and 2.

        ``clip=True`` moves points outside the table to its edge; without it they are refused.

        Raises
        ------
        ModelError : order out of range, a NaN, or a point outside the table with clip=False.
        """
        _check_order(self.name, dx)
        inside = points_inside(self.name, self.x_name, x, self.x_range, clip)
        return np.asarray(self._spline(inside, nu=dx), dtype=np.float64)

    def bounds(self, x: Interval, dx: int = 0) -> Interval:
        """Return a rigorous enclosure of a derivative over x, in exact arithmetic.

        Parameters
        ----------
        dx : order 0, 1 or 2.

        Raises
        ------
        ModelError : order out of range, or x leaves the table.
        """
        _check_order(self.name, dx)
        spline = _exact(self)
        require_inside(self.name, self.x_name, x, spline.x)
        return exact_bounds(spline, x, ORIGIN, dx, 0)

    def exact(self, x: Number, dx: int = 0) -> Fraction:
        """Return a derivative at one rational point, exactly; ModelError outside the table."""
        return self.bounds(Interval.of(x), dx).lower


def interpolate_curve(
    x: ArrayLike, values: ArrayLike, *, name: str = "curve", x_name: str = "x"
) -> Curve:
    """Return the cubic not-a-knot spline through (x[i], values[i]).

    The coefficients come from a linear system in floats, rounded to 14 digits of the largest one,
    so that what is odd or even stays so: a table through the origin that is odd is 0 there exactly.
    The result is defined by them: it passes through the other values to about 1e-14 of the largest.

    Raises
    ------
    ModelError : fewer than 4 points, x not increasing, a number that is not finite, or sizes that
        differ.

    Source: de Boor (1978), A Practical Guide to Splines, ch. IV (not-a-knot).
    """
    points = np.asarray(x, dtype=np.float64)
    table = np.asarray(values, dtype=np.float64)
    if points.ndim != 1 or points.shape != table.shape:
        raise ModelError(f"{name}: {table.shape} values for {points.shape} points; one each")
    if len(points) < DEGREE + 1:
        raise ModelError(f"{name}: {len(points)} points in {x_name}; a cubic needs at least 4")
    if not (np.all(np.isfinite(points)) and np.all(np.diff(points) > 0)):
        raise ModelError(f"{name}: {x_name} must be finite and strictly increasing")
    if not np.all(np.isfinite(table)):
        raise ModelError(f"{name}: every value must be a finite number")
    spline = make_interp_spline(points, table, k=DEGREE)
    return Curve(np.asarray(spline.t), _rounded(np.asarray(spline.c)), name=name, x_name=x_name)


def _rounded(coefficients: Floats) -> Floats:
    largest = float(np.abs(coefficients).max())
    if largest == 0:
        return coefficients
    decimals = DIGITS - 1 - int(np.floor(np.log10(largest)))
    return np.array([round(float(c), decimals) + 0.0 for c in coefficients])


def _check_order(name: str, order: int) -> None:
    if order not in range(MAX_ORDER + 1):
        raise ModelError(f"{name}: derivative {order} asked; orders are 0, 1 or 2")


@lru_cache(maxsize=64)
def _exact(curve: Curve) -> ExactSpline:
    """Return the curve in rational numbers; built once, then kept (curves are immutable)."""
    values = [exact(entry) for entry in curve.coefficients.tolist()]
    scale = lcm(*(value.denominator for value in values))
    rows = tuple((int(value * scale),) * (DEGREE + 1) for value in values)
    return exact_spline(tuple(exact(k) for k in curve.knots.tolist()), FLAT_KNOTS, rows, scale)
