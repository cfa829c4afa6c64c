"""Interpolating bicubic spline of a table, with exact derivatives and rigorous ranges.

The spline is *defined* by the decimals of its knots and coefficients (12 decimals).  The table it
was made from is reproduced to about 1e-12; floats evaluate it to rounding, and ``bounds`` encloses
it in exact arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import NdBSpline, make_interp_spline

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.splines.exact_spline import (
    DEGREE,
    MAX_ORDER,
    ExactSpline,
    exact_bounds,
    exact_spline,
    exact_value,
    points_inside,
    require_inside,
)

DECIMALS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Bicubic spline s(x, y) = sum_ij c_ij N_i(x) N_j(y), degree 3 in each direction.

    Attributes
    ----------
    x_knots, y_knots : full knot vectors, (nx + 4,) and (ny + 4,), decimals with 12 places.
    coefficients : (nx, ny), decimals with 12 places.
    name, x_name, y_name : words for messages, e.g. ``"c_P"``, ``"tip-speed ratio [-]"``.

    Raises
    ------
    ModelError : sizes that do not fit, unsorted knots, NaN, or numbers with more decimals.
    """

    x_knots: Floats
    y_knots: Floats
    coefficients: Floats
    name: str = "surface"
    x_name: str = "x"
    y_name: str = "y"
    _spline: NdBSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("x_knots", "y_knots", "coefficients"):
            array = np.array(getattr(self, name), dtype=np.float64)
            if not np.all(np.isfinite(array)) or np.any(np.round(array, DECIMALS) != array):
                raise ModelError(
                    f"{self.name}: {name} must be finite decimals with at most {DECIMALS} places; "
                    "round them before building the surface"
                )
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        self._check_sizes()
        spline = NdBSpline((self.x_knots, self.y_knots), self.coefficients, DEGREE)
        object.__setattr__(self, "_spline", spline)

    def _check_sizes(self) -> None:
        expected = (len(self.x_knots) - DEGREE - 1, len(self.y_knots) - DEGREE - 1)
        if self.coefficients.shape != expected or min(expected) < DEGREE + 1:
            raise ModelError(
                f"{self.name}: coefficients have shape {self.coefficients.shape}, but the knots "
                f"ask for {expected} (at least 4 in each direction)"
            )
        for name, knots in (("x_knots", self.x_knots), ("y_knots", self.y_knots)):
            simple = np.all(np.diff(knots[DEGREE : len(knots) - DEGREE]) > 0)
            if np.any(np.diff(knots) < 0) or not simple:
                raise ModelError(f"{self.name}: {name} must increase, inner knots strictly")

    @property
    def x_range(self) -> tuple[float, float]:
        """Smallest and largest x of the table."""
        return float(self.x_knots[DEGREE]), float(self.x_knots[-DEGREE - 1])

    @property
    def y_range(self) -> tuple[float, float]:
        """Smallest and largest y of the table."""
        return float(self.y_knots[DEGREE]), float(self.y_knots[-DEGREE - 1])

    def __call__(
        self, x: ArrayLike, y: ArrayLike, dx: int = 0, dy: int = 0, *, clip: bool = False
    ) -> Floats:
        """Return d^(dx+dy) s / dx^dx dy^dy at the points, broadcast; derivatives are exact.

        Parameters
        ----------
        x, y : numbers or arrays that broadcast.
        dx, dy : orders 0, 1 or 2.
        clip : False refuses points outside the table.  True moves them to its edge: the value is
            then held constant, while derivatives are those *at* the edge.

        Raises
        ------
        ModelError : order out of range, a NaN, or a point outside the table with clip=False.
        """
        if dx not in range(MAX_ORDER + 1) or dy not in range(MAX_ORDER + 1):
            raise ModelError(f"{self.name}: derivative ({dx}, {dy}) asked; orders are 0, 1 or 2")
        inside_x = points_inside(self.name, self.x_name, x, self.x_range, clip)
        inside_y = points_inside(self.name, self.y_name, y, self.y_range, clip)
        if inside_x.shape != inside_y.shape:
            inside_x, inside_y = np.broadcast_arrays(inside_x, inside_y)
        points = np.stack((inside_x, inside_y), axis=-1)
        return np.asarray(self._spline(points, nu=(dx, dy)), dtype=np.float64)

    def bounds(self, x: Interval, y: Interval, dx: int = 0, dy: int = 0) -> Interval:
        """Return a rigorous enclosure of a partial derivative over the rectangle x times y.

        The union of the Bernstein hulls of the cells that the rectangle meets, in exact
        arithmetic: see ``takagi.models.splines.exact_spline``.

        Parameters
        ----------
        dx, dy : orders 0, 1 or 2.

        Raises
        ------
        ModelError : order out of range, or the rectangle leaves the table.
        """
        spline = _exact(self)
        require_inside(self.name, self.x_name, x, spline.x)
        require_inside(self.name, self.y_name, y, spline.y)
        return exact_bounds(spline, x, y, dx, dy)

    def exact(self, x: Number, y: Number, dx: int = 0, dy: int = 0) -> Fraction:
        """Return a partial derivative at one rational point, exactly."""
        return exact_value(_exact(self), exact(x), exact(y), dx, dy)


def interpolate(
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    *,
    name: str = "surface",
    x_name: str = "x",
    y_name: str = "y",
) -> Surface:
    """Return the bicubic not-a-knot spline through values[i, j] at (x[i], y[j]).

    x, y and then the coefficients are rounded to 12 decimals; the result is defined by those.

    Raises
    ------
    ModelError : fewer than 4 points in a direction, unsorted points, NaN, or sizes that differ.

    Source: de Boor (1978), A Practical Guide to Splines, ch. IV (not-a-knot) and XVII (tensor).
    """
    points = [_rounded(axis) for axis in (x, y)]
    table = np.asarray(values, dtype=np.float64)
    _check_table(name, points, table, (x_name, y_name))
    along_x = make_interp_spline(points[0], table, k=DEGREE)
    along_y = make_interp_spline(points[1], np.asarray(along_x.c).T, k=DEGREE)
    coefficients = _rounded(np.asarray(along_y.c).T)
    return Surface(along_x.t, along_y.t, coefficients, name=name, x_name=x_name, y_name=y_name)


def _rounded(values: ArrayLike) -> Floats:
    return np.asarray(np.round(np.asarray(values, dtype=np.float64), DECIMALS), dtype=np.float64)


def _check_table(name: str, points: list[Floats], table: Floats, axes: tuple[str, str]) -> None:
    expected = tuple(len(axis) for axis in points)
    if table.shape != expected:
        raise ModelError(f"{name}: the table has shape {table.shape}, its axes ask for {expected}")
    for axis, axis_name in zip(points, axes, strict=True):
        if len(axis) < DEGREE + 1:
            raise ModelError(f"{name}: {len(axis)} points in {axis_name}; a cubic needs at least 4")
        if not np.all(np.isfinite(axis)) or np.any(np.diff(axis) <= 0):
            raise ModelError(f"{name}: {axis_name} must be finite and strictly increasing")
    if not np.all(np.isfinite(table)):
        i, j = np.argwhere(~np.isfinite(table))[0]
        raise ModelError(
            f"{name}: the value at {axes[0]} = {points[0][i]:.9g}, {axes[1]} = {points[1][j]:.9g} "
            f"is {table[i, j]}; every cell needs a finite number"
        )


@lru_cache(maxsize=16)
def _exact(surface: Surface) -> ExactSpline:
    """Return the surface in rational numbers; built once, then kept (surfaces are immutable)."""
    scale = 10**DECIMALS
    coefficients = tuple(
        tuple(int(exact(entry) * scale) for entry in row) for row in surface.coefficients.tolist()
    )
    x_knots = tuple(exact(knot) for knot in surface.x_knots.tolist())
    y_knots = tuple(exact(knot) for knot in surface.y_knots.tolist())
    return exact_spline(x_knots, y_knots, coefficients, scale)
