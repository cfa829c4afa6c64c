r"""The closed loop with a published law as an interval family, one for each wind cell.

For winds v of a cell and a centre z_0(v), linear in v, the mean value theorem over the box
|z_i - z_0i(v)| <= r_i (cut at smallest pitch, below which pitch never goes) gives

    z' = d + A (z - z_0(v)),     d = f(z_0(v), v),     A in the hull of the corners' ranges

where f is the field of ``vector_field``.  In y = (z - z_0)/r all sizes are comparable, so the
family is emitted in these units: A_ij r_j / r_i and d_i / r_i, both in 1/s.

d is bounded from the field at the cell's middle and the range of its slope along the centres.
Winds are constant and v_hat = v.

The checker's ``turbine.published.loop`` encloses the same loop in exact numbers.  The search asks
for some ten thousand cells, and these floats answer two to three times faster.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.dual import Dual, Range
from takagi.models.laws.published.loop_tables import LoopFigures
from takagi.models.laws.published.vector_field import Corner, PublishedVectorField, StateRange

EMITTED_DIGITS = 7
# Emitted ranges are wider than the computed ones by this share of the largest entry of their
# row, which is far more than the rounding errors in floating or fixed point.
WIDENED = 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class PublishedCell:
    """Ranges of the family over one cell, in units of the box.

    Attributes
    ----------
    wind : (v_1, v_2) [m/s].
    centre : (2, n) z_0 at both winds;  box : (n,) r.  Units rad/s, rad, rad.
    low, high : (corners, n, n) [1/s].
    disturbance : (n,) bound on |d_i| / r_i [1/s].
    """

    wind: Range
    centre: Floats
    box: Floats
    low: Floats
    high: Floats
    disturbance: Floats


def enclosed_cell(
    figures: LoopFigures,
    wind: Range,
    centre: Floats,
    box: Floats,
    disturbance: Floats | None = None,
) -> PublishedCell:
    """Return the family of one cell; ``disturbance`` is that of ``disturbance_bound``, if known.

    Raises
    ------
    ModelError : the box leaves the coefficient table or may demand more than the pitch rate
        limit, or an integral gain may vanish in it.
    """
    try:
        low, high = _jacobian(figures, wind, centre, box)
        bound = disturbance_bound(figures, wind, centre) if disturbance is None else disturbance
    except ZeroDivisionError as error:
        raise ModelError(
            f"wind {wind[0]:.6g} to {wind[1]:.6g} m/s: {error} in a divisor"
        ) from error
    size = np.maximum(np.abs(low), np.abs(high)).max(axis=(0, 2), keepdims=True) * WIDENED
    return PublishedCell(
        wind,
        centre,
        box,
        _outward(low - size * (low != 0), math.floor),
        _outward(high + size * (high != 0), math.ceil),
        _outward(bound / box * (1 + WIDENED) + 1e-6, math.ceil),
    )


def wind_breaks(figures: LoopFigures, low: float, high: float) -> list[float]:
    """Return the winds between which tables and reference speed are smooth, ends included.

    Where the reference speed bends is not a decimal: two breaks enclose such a wind.
    """
    nodes = {*figures.partial.trim.wind, *figures.full.trim.wind}
    radius, per_ratio = figures.radius, figures.optimal_ratio
    for speed, ratio in (
        (figures.minimum_speed, per_ratio),
        (figures.speed_setpoint, per_ratio),
        (figures.minimum_speed, figures.largest_ratio),
    ):
        bend = speed * radius / ratio
        # A corner is at a wind that is usually not a decimal. The cell between its two neighbours
        # of six decimals contains it, and all other cells are smooth.
        nodes |= {math.floor(bend * 1e6) / 1e6, math.ceil(bend * 1e6) / 1e6}
    return sorted({low, high, *(v for v in nodes if low < v < high)})


def _jacobian(
    figures: LoopFigures, wind: Range, centre: Floats, box: Floats
) -> tuple[Floats, Floats]:
    n = len(box)
    state = []
    for i, (first, last, r) in enumerate(zip(*centre.tolist(), box.tolist(), strict=True)):
        value = (min(first, last) - r, max(first, last) + r)
        if i == 1:
            value = max(value[0], figures.pitch_limits[0]), min(value[1], figures.pitch_limits[1])
        seeds = tuple((r, r) if j == i else (0.0, 0.0) for j in range(n))
        state.append(Dual(value, seeds))
    speeds = tuple((float(c[0] - box[0]), float(c[0] + box[0])) for c in centre)
    constant_wind = Dual(wind, ((0.0, 0.0),) * n)
    field = PublishedVectorField(
        figures, StateRange(constant_wind, tuple(state), (speeds[0], speeds[1]))
    )
    matrices = [_matrix(field, corner) / box[None, :, None] for corner in field.corners()]
    return np.stack([m[0] for m in matrices]), np.stack([m[1] for m in matrices])


def _matrix(field: PublishedVectorField, corner: Corner) -> Floats:
    rows = np.array([row.slopes for row in field(corner)])
    return np.moveaxis(rows, 2, 0)[:, :, :]


def disturbance_bound(figures: LoopFigures, wind: Range, centre: Floats) -> Floats:
    """Return (n,) bounds of |f_i(z_0(v), v)| over the cell, in SI units."""
    first, last = centre
    width = wind[1] - wind[0]
    slope = (last - first) / width
    along = _along(figures, wind, centre, (1.0, slope.tolist()))
    middle = (wind[0] + wind[1]) / 2
    point = (first + last) / 2
    there = _along(figures, (middle, middle), np.stack([point, point]), None)
    steepest = np.array([max(-row.slopes[0][0], row.slopes[0][1]) for row in along])
    at_middle = np.array([max(-row.value[0], row.value[1]) for row in there])
    return np.asarray(at_middle + steepest * width / 2)


def _along(
    figures: LoopFigures, wind: Range, centre: Floats, slope: tuple[float, list[float]] | None
) -> tuple[Dual, ...]:
    pace, slopes = slope if slope else (0.0, [0.0] * centre.shape[1])
    state = tuple(
        Dual((min(a, b), max(a, b)), ((s, s),) if slope else ())
        for a, b, s in zip(*centre.tolist(), slopes, strict=True)
    )
    speeds = tuple((float(c[0]), float(c[0])) for c in centre)
    moving = Dual(wind, ((pace, pace),) if slope else ())
    return PublishedVectorField(figures, StateRange(moving, state, (speeds[0], speeds[1])))()


def _outward(values: Floats, rounding: object) -> Floats:
    scale = 10.0**EMITTED_DIGITS
    rounded = np.floor if rounding is math.floor else np.ceil
    return np.asarray(rounded(values * scale) / scale)
