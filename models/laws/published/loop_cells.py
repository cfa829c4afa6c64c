"""The loop of a published law: its vector field with slopes, cell by cell.

The closed loop with a published law, evaluated on ranges with slopes.

    omega' = T_r(omega, beta, v)/J - n_g T/J        T        = phi(u_1), held to 0..T_rated
    beta'  = (beta_ref - beta)/tau_beta             beta_ref = f_1(omega) u_2, held to its range
    x'     = -e                                     one integrator, or
    x_b'   = -e + (phi(u_1) - u_1)/(tau k^b_I),     x_c' = -e + (beta_ref - u_2)/(tau k^c_I)

with v_hat = v.  Everything goes through ``Dual``: seeded with the states it gives the Jacobian's
ranges, seeded along a line of centres it gives the derivative of the field there, without seeds
the field at a point.

The premises are averages of second-order-smooth slopes, a = int_0^1 T_w(w* + s (w - w*)) ds / J,
so a' lies in T_ww (w*' + w')/2 + T_wb b' + T_wv v', each range taken over the segment: int s ds =
1/2 and s >= 0.  The secant is meant exactly; at run time a difference quotient of 1e-4 stands in
where the segment is short.

The field is affine in two numbers: phi'(u_1), and 0 or 1 for pitch held at its limit or not. The
hull over the ends of both is tighter than one range for all. ``Corner`` picks an end of each.

Source: Schulte (2024), section "Fuzzy-Blending of Control Regions"; readings in docs/laws.md.

The closed loop with a published law as an interval family, one for each wind cell.

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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import (
    Dual,
    Range,
    constant,
    hull,
    larger,
    smaller,
    span,
    times,
)
from takagi.models.laws.published.loop_tables import GainTable, LoopFigures, TrimTable

End = Literal["all", "low", "high"]
Hold = Literal["all", "free", "held"]
# How accurately a checker knows a value of the surface, as a share of its scale.
NOISE = 2e-12


@dataclass(frozen=True, slots=True)
class Corner:
    """The end of phi' that is taken, and whether pitch counts as held; "all" takes the range."""

    torque: End = "all"
    pitch: Hold = "all"


@dataclass(frozen=True, slots=True)
class StateRange:
    """Where the field is evaluated: winds [low, high] and a state, linear in wind at its centre.

    Attributes
    ----------
    wind : the wind with its slopes.
    state : omega [rad/s], beta [rad], the integrals [rad], with their slopes.
    speeds : range of omega at the lowest and at the highest wind; between them it is linear.
    """

    wind: Dual
    state: tuple[Dual, ...]
    speeds: tuple[Range, Range]


class PublishedVectorField:
    """The field over one ``StateRange``; what all corners share is computed once."""

    def __init__(self, figures: LoopFigures, states: StateRange) -> None:
        self.figures, self.place = figures, states
        self.speed, self.pitch = states.state[0], states.state[1]
        self.wind = states.wind

    def __call__(self, corner: Corner | None = None) -> tuple[Dual, ...]:
        """Return the derivatives of all states.

        Raises
        ------
        ModelError : the place leaves the coefficient table, or may demand more than the pitch
            rate limit.
        """
        pick, f = corner or Corner(), self.figures
        torque, torque_gap = self._torque(pick)
        angle, angle_gap = self._angle(pick)
        rate = (angle - self.pitch).scaled(1 / f.pitch_time)
        if max(-rate.value[0], rate.value[1]) > f.pitch_rate_limit:
            raise ModelError(
                f"the box may demand {max(-rate.value[0], rate.value[1]):.4g} rad/s of pitch rate, "
                f"the limit is {f.pitch_rate_limit:.4g}; take a smaller box"
            )
        acceleration = self.rotor - torque.scaled(f.gear_per_inertia)
        if f.tracking_time is None:
            return acceleration, rate, -self.error
        pace = 1 / f.tracking_time
        partial = torque_gap * self._gains(f.partial, self.partial_weights)[2].inverse()
        full = angle_gap * self._gains(f.full, self.full_weights)[2].inverse()
        return acceleration, rate, partial.scaled(pace) - self.error, full.scaled(pace) - self.error

    def corners(self) -> list[Corner]:
        """Return the corners whose hull holds every Jacobian of the place."""
        low, high = self._torque_slope(self.torque_command.value)
        torques: tuple[End, ...] = ("low",) if low == high else ("low", "high")
        free, at_limit = self._holds()
        pitches = [hold for hold, there in (("free", free), ("held", at_limit)) if there]
        return [Corner(t, p) for t in torques for p in pitches]  # type: ignore[arg-type]

    # ------------------------------------------------------------------ plant and reference
    @cached_property
    def rotor(self) -> Dual:
        """T_r / J [rad/s^2]."""
        ratio = self._ratios(None, self.speed.value, self.wind.value)
        orders = ((0, 0), (1, 0), (0, 1))
        c, by_ratio, by_pitch = self.figures.surface(ratio, self.pitch.value, orders)
        k, v = self.figures.torque_per_inertia, self.wind.value
        squared = (k * v[0] ** 2, k * v[1] ** 2)
        by_speed = times(by_ratio, (k * self.figures.radius * v[0], k * self.figures.radius * v[1]))
        lever = times(ratio, by_ratio)
        by_wind = times((2 * c[0] - lever[1], 2 * c[1] - lever[0]), (k * v[0], k * v[1]))
        return _chain_rule(
            times(c, squared),
            (by_speed, self.speed),
            (times(by_pitch, squared), self.pitch),
            (by_wind, self.wind),
        )

    @cached_property
    def error(self) -> Dual:
        """omega - omega_ref(v)."""
        f, v = self.figures, self.wind.held(self.figures.cut_in, self.figures.cut_out)
        lowest = smaller(constant(f.minimum_speed, v), v.scaled(f.largest_ratio / f.radius))
        reference = larger(v.scaled(f.optimal_ratio / f.radius), lowest)
        return self.speed - smaller(reference, constant(f.speed_setpoint, v))

    # ------------------------------------------------------------------ scheduled gains
    @cached_property
    def partial_weights(self) -> tuple[Dual, ...]:
        return (self._speed_weight(self.figures.partial, None),)

    @cached_property
    def full_weights(self) -> tuple[Dual, ...]:
        table = self.figures.full
        return self._speed_weight(table, self.pitch), self._pitch_weight(table)

    def _speed_weight(self, gains: GainTable, pitch: Dual | None) -> Dual:
        """Return the weight of a = [T_r(omega, beta, v) - T_r(omega*, beta, v)] / (J (...))."""
        table, f = gains.trim, self.figures
        wind = self.wind.held(*table.range)
        speed = table.speed(self.wind)
        angle = table.pitch(self.wind) if pitch is None else pitch
        ratio = self._ratios(table, hull(speed.value, self.speed.value), wind.value)
        k, v = f.torque_per_inertia * f.radius, wind.value
        orders = ((1, 0), (2, 0), (1, 1))
        first, second, mixed = f.surface(ratio, angle.value, orders)
        scale, bent = (k * v[0], k * v[1]), (k * f.radius, k * f.radius)
        lever = times(ratio, second)
        by_wind = times((first[0] - lever[1], first[1] - lever[0]), (k, k))
        half = times(second, (bent[0] / 2, bent[1] / 2))
        slope = _chain_rule(
            times(first, scale),
            (half, speed),
            (half, self.speed),
            (times(mixed, scale), angle),
            (by_wind, wind),
        )
        if not slope.slopes:
            squared = (f.torque_per_inertia * v[0] ** 2, f.torque_per_inertia * v[1] ** 2)
            ratios = [
                (at.value[0] * f.radius / v[1], at.value[1] * f.radius / v[0])
                for at in (speed, self.speed)
            ]
            start, end = (times(f.surface(r, angle.value, ((0, 0),))[0], squared) for r in ratios)
            slope = _secant(slope, start, end, speed, self.speed, squared)
        return gains.weight(0, slope)

    def _pitch_weight(self, gains: GainTable) -> Dual:
        """Return the weight of b = [T_r(omega*, beta, v) - T_r(omega*, beta*, v)] / (J (...))."""
        table, f = gains.trim, self.figures
        wind, speed, trim = (
            self.wind.held(*table.range),
            table.speed(self.wind),
            table.pitch(self.wind),
        )
        ratio = self._ratios(table, speed.value, wind.value, trim_only=True)
        orders = ((0, 1), (0, 2), (1, 1))
        angle = hull(trim.value, self.pitch.value)
        first, second, mixed = f.surface(ratio, angle, orders)
        k, v = f.torque_per_inertia, wind.value
        squared, linear = (k * v[0] ** 2, k * v[1] ** 2), (k * v[0], k * v[1])
        half = times(second, (squared[0] / 2, squared[1] / 2))
        lever = times(ratio, mixed)
        by_wind = times((2 * first[0] - lever[1], 2 * first[1] - lever[0]), linear)
        slope = _chain_rule(
            times(first, squared),
            (half, trim),
            (half, self.pitch),
            (times(mixed, (f.radius * linear[0], f.radius * linear[1])), speed),
            (by_wind, wind),
        )
        if not slope.slopes:
            start, end = (
                times(f.surface(ratio, at.value, ((0, 0),))[0], squared)
                for at in (trim, self.pitch)
            )
            slope = _secant(slope, start, end, trim, self.pitch, squared)
        return gains.weight(1, slope)

    def _ratios(
        self, table: TrimTable | None, speeds: Range, winds: Range, *, trim_only: bool = False
    ) -> Range:
        """Return the range of omega R / v, omega at the state, at the trim, or between both.

        Between breaks of the table both speed and wind are lines in v, so that the ratio is
        monotone and its ends at the breaks decide.
        """
        low, high = self.wind.value
        breaks = [low, high]
        if table is not None:
            breaks += [node for node in table.wind if low < node < high]
        ratios = []
        for v in breaks:
            share = 0.0 if high == low else (v - low) / (high - low)
            first, last = self.place.speeds
            here = [first[i] + share * (last[i] - first[i]) for i in (0, 1)]
            at = v if table is None else min(max(v, table.range[0]), table.range[1])
            if table is not None:
                trim = table.speed_at(v)
                here = [trim] if trim_only else [*here, trim]
            ratios += [omega * self.figures.radius / at for omega in here]
        return span(*ratios)

    def _gains(self, table: GainTable, weights: Sequence[Dual]) -> tuple[Dual, Dual, Dual]:
        speed, pitch, integral = (table.blended(kind, weights) for kind in range(3))
        return speed, pitch, integral

    # ------------------------------------------------------------------ torque channel
    @cached_property
    def torque_command(self) -> Dual:
        """u_1."""
        speed, _, integral = self._gains(self.figures.partial, self.partial_weights)
        return integral * self.place.state[2] - speed * self.error

    def _torque(self, corner: Corner) -> tuple[Dual, Dual]:
        """Return the torque phi(u_1) held at 0, and its difference from the command."""
        u, f = self.torque_command, self.figures
        low, high = u.value
        slope = self._torque_slope(u.value)
        if corner.torque != "all":
            end = slope[0] if corner.torque == "low" else slope[1]
            slope = (end, end)
        value = (f.passed(low), f.passed(high))
        # phi - u decreases, so its range is given by the ends.
        gap = (f.passed(high) - high, f.passed(low) - low)
        return u.through(value, slope), u.through(gap, (slope[0] - 1, slope[1] - 1))

    def _torque_slope(self, command: Range) -> Range:
        f = self.figures
        return (
            0.0 if command[0] < 0 else f.passed_slope(command[1]),
            f.passed_slope(max(command[0], 0.0)) if command[1] > 0 else 0.0,
        )

    # ------------------------------------------------------------------ pitch channel
    @cached_property
    def pitch_command(self) -> Dual:
        """u_2."""
        speed, pitch, integral = self._gains(self.figures.full, self.full_weights)
        return integral * self.place.state[-1] - speed * self.error - pitch * self.pitch

    @cached_property
    def share(self) -> Dual:
        """f_1(omega)."""
        ramp = self.figures.speed_ramp.at
        low, high = self.speed.value
        return self.speed.through((ramp(low), ramp(high)), self.figures.ramp_slope(low, high))

    def _holds(self) -> tuple[bool, bool]:
        """Return whether pitch may be free, and whether it may be held at a limit."""
        low, high = (self.share * self.pitch_command).value
        bottom, top = self.figures.pitch_limits
        return high >= bottom and low <= top, low < bottom or high > top

    def _angle(self, corner: Corner) -> tuple[Dual, Dual]:
        """Return the pitch reference, and its difference from the command u_2."""
        u, (bottom, top) = self.pitch_command, self.figures.pitch_limits
        free, at_limit = self._holds()
        blended = self.share * u
        remainder = self.share.plus(-1.0) * u
        angle = blended.held(bottom, top)
        low, high = blended.value
        limits = [end for end, reached in ((bottom, low < bottom), (top, high > top)) if reached]
        gaps = [remainder] if free or not limits else []
        gaps += [constant(end, u) - u for end in limits]
        gap = hull(*(g.value for g in gaps))
        keep = corner.pitch == "free" or (corner.pitch == "all" and not at_limit)
        drop = corner.pitch == "held" or (corner.pitch == "all" and not free)
        if keep:
            return Dual(angle.value, blended.slopes), Dual(gap, remainder.slopes)
        if drop:
            return angle.through(angle.value, (0.0, 0.0)), Dual(gap, (-u).slopes)
        slopes = tuple(
            hull(*slope_ranges) for slope_ranges in zip(*(g.slopes for g in gaps), strict=True)
        )
        return angle, Dual(gap, slopes)


def _secant(
    slope: Dual, start_value: Range, end_value: Range, start: Dual, end: Dual, scale: Range
) -> Dual:
    """Return the difference quotient if it is tighter than the range of the derivative."""
    step = (end.value[0] - start.value[1], end.value[1] - start.value[0])
    if step[0] <= 0.0 <= step[1]:
        return slope
    # A checker may know surface values only up to NOISE, and a short step amplifies that error.
    noise = NOISE * (abs(scale[0]) + abs(scale[1]))
    rise = (end_value[0] - start_value[1] - noise, end_value[1] - start_value[0] + noise)
    quotient = times(rise, (1 / step[1], 1 / step[0]))
    low, high = max(quotient[0], slope.value[0]), min(quotient[1], slope.value[1])
    return Dual((low, high), ()) if low <= high else slope


def _chain_rule(value: Range, *terms: tuple[Range, Dual]) -> Dual:
    """Return the quantity with this range whose slope is the sum of partial times inner slope."""
    slopes = []
    for k in range(len(terms[0][1].slopes)):
        products = [times(partial, inner.slopes[k]) for partial, inner in terms]
        slopes.append((sum(p[0] for p in products), sum(p[1] for p in products)))
    return Dual(value, tuple(slopes))


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
