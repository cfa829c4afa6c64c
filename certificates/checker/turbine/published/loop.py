r"""Enclosure of the closed loop with a published law, and of its slopes.

    omega' = T_r(omega, beta, v)/J - n_g T/J,     T = max(phi(u_1), 0)
    beta'  = (beta_ref - beta)/tau_beta,          beta_ref = f_1(omega) u_2 within pitch limits
    u      = -k_w (omega - omega_ref(v)) - k_p beta + k_I x, gains multilinear in premise weights
    x'     = omega_ref - omega

phi passes torque, is a parabola over the torque overlap and then rated torque.  Premises are
averages of dT_r/domega (a) and dT_r/dbeta (b) between the trim of the wind and the state, each
over J; the average of a second derivative with weight s or 1 - s lies in half of its range.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import product

from takagi.certificates.checker.arithmetic.dual import Dual, chained, greater, lesser, still
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
    hull,
    point,
)
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.published.inputs import (
    STATES,
    Overlaps,
    PublishedLaw,
    Region,
)
from takagi.certificates.checker.turbine.rotor import Plant

HALF = Interval(ONE // 2, ONE // 2)


@dataclass(frozen=True)
class Ends:
    """A range of winds, and a line of states over it with half widths around it, exactly.

    Attributes
    ----------
    wind : (v_1, v_2), equal for a point.
    states : z_0 at both.
    widths : half widths r; zero for the line itself.
    """

    wind: tuple[Fraction, Fraction]
    states: tuple[list[Fraction], list[Fraction]]
    widths: list[Fraction]


class Loop:
    """The loop over a piece of wind; ``seeds`` chooses along what slopes are taken.

    seeds "states": one direction per state, of length r.  "line": along the centres, per unit of
    wind.  "none": values only.
    """

    def __init__(
        self, plant: Plant, law: PublishedLaw, overlaps: Overlaps, ends: Ends, seeds: str
    ) -> None:
        self.plant, self.law, self.overlaps, self.ends = plant, law, overlaps, ends
        count = {"states": STATES, "line": 1, "none": 0}[seeds]
        v1, v2 = ends.wind
        pace = UNIT if seeds == "line" else ZERO
        self.wind = Dual(enclose(v1, v2), (pace,) * count)
        self.state = []
        for i, (first, last, r) in enumerate(zip(*ends.states, ends.widths, strict=True)):
            low, high = min(first, last) - r, max(first, last) + r
            if i == 1:
                low, high = max(low, law.pitch_min), min(high, law.pitch_max)
            slopes = [ZERO] * count
            if seeds == "states":
                slopes[i] = point(r)
            elif seeds == "line":
                slopes[0] = point((last - first) / (v2 - v1))
            self.state.append(Dual(enclose(low, high), tuple(slopes)))
        self.speed, self.pitch = self.state[:2]
        self.sharp = seeds == "none"

    # ------------------------------------------------------------------ the field
    def rates(self, torque_end: int | None = None, free: bool | None = None) -> list[Dual]:
        """Return z'.

        Parameters
        ----------
        torque_end : the end of the range of phi' to use; None uses the whole range.
        free : whether pitch is free or at a limit; None covers both.
        """
        plant = self.plant
        turning = (self._angle(free) - self.pitch).by(point(1 / plant.lag))
        if turning.value.magnitude() > point(plant.rate_limit)[0]:
            raise Refused("the set may demand more than the pitch rate limit")
        braking = self._torque(torque_end).by(point(plant.gear_per_inertia))
        return [self.rotor - braking, turning, -self.error]

    def commands(self) -> tuple[Dual, Dual]:
        """Return the pitch reference and the torque, within the limits of the law."""
        return self._angle(None), self._torque(None)

    def choices(self) -> list[tuple[int, bool]]:
        """Return the (torque_end, free) whose hull holds every Jacobian."""
        low, high = self.torque_slope
        ends = (0,) if low == high else (0, 1)
        may_be_free, may_be_held = self.pitch_cases
        cases = [case for case, there in ((True, may_be_free), (False, may_be_held)) if there]
        return list(product(ends, cases))

    # ------------------------------------------------------------------ rotor and reference
    @cached_property
    def rotor(self) -> Dual:
        """T_r / J = c v^2 c_Q(omega R / v, beta)."""
        plant, v, angle = self.plant, self.wind.value, self.pitch.value
        ratio = self._ratio(None, True, False)
        return chained(
            plant.torque(ratio, angle, v),
            (plant.torque_by_speed(ratio, angle, v), self.speed),
            (plant.torque_by_pitch(ratio, angle, v), self.pitch),
            (plant.torque_by_wind(ratio, angle, v), self.wind),
        )

    @cached_property
    def error(self) -> Dual:
        """omega - omega_ref(v)."""
        law, radius = self.law, self.plant.radius
        v = self._held_wind(law.cut_in, law.cut_out)
        floor = lesser(still(point(law.minimum_speed), v), v.by(point(law.largest_ratio / radius)))
        wanted = greater(v.by(point(law.optimal_ratio / radius)), floor)
        return self.speed - lesser(wanted, still(point(law.setpoint), v))

    # ------------------------------------------------------------------ premises and gains
    @cached_property
    def partial_weights(self) -> list[Dual]:
        region = self.law.partial
        trim = self._column(region, "pitch")
        return [_weight(self._speed_premise(region, trim), region.bounds[0])]

    @cached_property
    def full_weights(self) -> list[Dual]:
        region = self.law.full
        first = _weight(self._speed_premise(region, self.pitch), region.bounds[0])
        return [first, _weight(self._pitch_premise(region), region.bounds[1])]

    def _speed_premise(self, region: Region, angle: Dual) -> Dual:
        c, radius = point(self.plant.torque_per_inertia), point(self.plant.radius)
        wind, trim = (
            self._held_wind(region.wind[0], region.wind[-1]),
            self._column(region, "speed"),
        )
        ratio, bounds = self._ratio(region, True, True), self.plant.surface.bounds
        first, second = bounds(ratio, angle.value, 1, 0), bounds(ratio, angle.value, 2, 0)
        cr = c * radius
        crv = cr * wind.value
        half = HALF * (cr * radius * second)
        found = chained(
            crv * first,
            (half, trim),
            (half, self.speed),
            (crv * bounds(ratio, angle.value, 1, 1), angle),
            (cr * (first - ratio * second), wind),
        )
        if not self.sharp:
            return found
        cvv = c * wind.value.square()
        at_trim = cvv * bounds(self._ratio(region, False, True), angle.value)
        at_state = cvv * bounds(self._ratio(region, True, False), angle.value)
        return _quotient(found, at_state - at_trim, self.speed.value - trim.value)

    def _pitch_premise(self, region: Region) -> Dual:
        c, radius = point(self.plant.torque_per_inertia), point(self.plant.radius)
        wind, trim = (
            self._held_wind(region.wind[0], region.wind[-1]),
            self._column(region, "pitch"),
        )
        speed, bounds = self._column(region, "speed"), self.plant.surface.bounds
        ratio = self._ratio(region, False, True)
        angle = hull(trim.value, self.pitch.value)
        first, mixed = bounds(ratio, angle, 0, 1), bounds(ratio, angle, 1, 1)
        cv, cvv = c * wind.value, c * wind.value.square()
        half = HALF * (cvv * bounds(ratio, angle, 0, 2))
        found = chained(
            cvv * first,
            (half, trim),
            (half, self.pitch),
            (cv * radius * mixed, speed),
            (cv * (first + first - ratio * mixed), wind),
        )
        if not self.sharp:
            return found
        rise = cvv * (bounds(ratio, self.pitch.value) - bounds(ratio, trim.value))
        return _quotient(found, rise, self.pitch.value - trim.value)

    def _held_wind(self, lowest: Fraction, highest: Fraction) -> Dual:
        """Return the wind limited to a range; this is exact, since cells end where ranges end."""
        low, high = self.ends.wind
        held = [min(max(v, lowest), highest) for v in (low, high)]
        moving = low < highest and high > lowest
        still_too = low < lowest or high > highest or not moving
        slope = Interval(0 if still_too else ONE, ONE if moving else 0)
        return self.wind.through(enclose(held[0], held[1]), slope)

    def _column(self, region: Region, name: str) -> Dual:
        """Return a column of the trim table at the wind: linear between nodes, held beyond."""
        return self.wind.through(*_column_range(region, name, *self.ends.wind))

    def _ratio(self, region: Region | None, of_state: bool, of_trim: bool) -> Interval:
        """Return the range of omega R / v for the state's speed, the trim's, or all between.

        Speeds and (held) wind are lines between the table's nodes, so the ratio is monotone there.
        """
        low, high = self.ends.wind
        first, last = (z[0] for z in self.ends.states)
        r, found = self.ends.widths[0], []
        for v in _breaks(region, low, high):
            at, trim = _held_trim(region, v) if region else (v, None)
            if of_state:
                share = (v - low) / (high - low) if high > low else Fraction(0)
                middle = first + share * (last - first)
                found += [(middle - r) / at, (middle + r) / at]
            if of_trim and trim is not None:
                found.append(trim / at)
        return enclose(min(found) * self.plant.radius, max(found) * self.plant.radius)

    # ------------------------------------------------------------------ torque
    @cached_property
    def torque_command(self) -> Dual:
        region, weights = self.law.partial, self.partial_weights
        speed, integral = blended(region, 0, weights), blended(region, 2, weights)
        return integral * self.state[2] - speed * self.error

    def _torque(self, end: int | None) -> Dual:
        u, slope = self.torque_command, self.torque_slope
        if end is not None:
            slope = Interval(slope[end], slope[end])
        low, high = (self._passed(x) for x in u.value)
        return u.through(Interval(low.low, high.high), slope)

    def _passed(self, x: int) -> Interval:
        """Return a bracket of max(phi, 0) at x / 10^36."""
        limit, half = self.law.rated_torque, self.overlaps.torque / 2
        u = Fraction(x, ONE)
        if u >= limit + half:
            return point(limit)
        if u <= limit - half:
            return Interval(max(x, 0), max(x, 0))
        return point(limit - (limit + half - u) ** 2 / (4 * half))

    @cached_property
    def torque_slope(self) -> Interval:
        """Return the range of the slope of max(phi, 0): it falls from 1 to 0 for u > 0."""
        low, high = self.torque_command.value
        limit, whole = self.law.rated_torque, self.overlaps.torque
        steepest, flattest = (
            min(max((limit + whole / 2 - Fraction(x, ONE)) / whole, Fraction(0)), Fraction(1))
            for x in (low, high)
        )
        bracket = enclose(flattest, steepest)
        return Interval(0 if low < 0 else bracket.low, 0 if high <= 0 else min(bracket.high, ONE))

    # ------------------------------------------------------------------ pitch
    @cached_property
    def pitch_command(self) -> Dual:
        speed, angle, integral = (
            blended(self.law.full, kind, self.full_weights) for kind in range(3)
        )
        return integral * self.state[2] - speed * self.error - angle * self.pitch

    @cached_property
    def share(self) -> Dual:
        """f_1(omega)."""
        low, high = (
            (Fraction(x, ONE) - self.overlaps.start) / self.overlaps.width for x in self.speed.value
        )
        a, b = (min(max(s, Fraction(0)), Fraction(1)) for s in (low, high))
        if not self.law.smooth:
            least, most = (Fraction(low >= 0 and high <= 1), Fraction(high > 0 and low < 1))
            value = enclose(a, b)
        else:
            steep = [6 * a * (1 - a), 6 * b * (1 - b)]
            least = min(steep)
            most = Fraction(3, 2) if 2 * a < 1 < 2 * b else max(steep)
            value = enclose(a * a * (3 - 2 * a), b * b * (3 - 2 * b))
        width = self.overlaps.width
        return self.speed.through(value, enclose(least / width, most / width))

    @cached_property
    def pitch_cases(self) -> tuple[bool, bool]:
        """Return whether pitch may be free, and whether it may be held at a limit."""
        low, high = (self.share * self.pitch_command).value
        bottom, top = point(self.law.pitch_min), point(self.law.pitch_max)
        return high >= bottom[0] and low <= top[1], low < bottom[1] or high > top[0]

    def _angle(self, free: bool | None) -> Dual:
        u = self.pitch_command
        blended = self.share * u
        bottom, top = point(self.law.pitch_min), point(self.law.pitch_max)
        value = lesser(greater(_bare(blended), Dual(bottom, ())), Dual(top, ())).value
        if free is None:
            may_be_free, may_be_held = self.pitch_cases
            cases = [blended] if may_be_free else []
            return _joined(value, [*cases, still(bottom, u)] if may_be_held else cases)
        return Dual(value, blended.slopes) if free else still(value, u)


def _bare(quantity: Dual) -> Dual:
    return Dual(quantity.value, ())


def _joined(value: Interval, parts: list[Dual]) -> Dual:
    return Dual(
        value, tuple(hull(*slopes) for slopes in zip(*(p.slopes for p in parts), strict=True))
    )


def _quotient(found: Dual, rise: Interval, step: Interval) -> Dual:
    """Return the average slope as a quotient, if the step is certainly not zero."""
    if step[0] <= 0 <= step[1]:
        return found
    sharp = rise / step
    value = Interval(max(sharp.low, found.value.low), min(sharp.high, found.value.high))
    if value.low > value.high:
        raise Refused("two brackets of one number do not meet")
    return Dual(value, found.slopes)


def _weight(premise: Dual, bounds: tuple[Fraction, Fraction]) -> Dual:
    shifted = premise.plus(point(-bounds[0])).by(point(1 / (bounds[1] - bounds[0])))
    return shifted.clamped(ZERO, UNIT)


def blended(region: Region, kind: int, weights: list[Dual]) -> Dual:
    """Return a gain; it is affine in each weight, so the corners of the weights give its range."""
    table, rises = _gain_tables(region, kind)
    values = [w.value for w in weights]
    terms = [
        (_corner_range(rise, values[:i] + values[i + 1 :]), weight)
        for i, (rise, weight) in enumerate(zip(rises, weights, strict=True))
    ]
    return chained(_corner_range(table, values), *terms)


@lru_cache(maxsize=64)
def _gain_tables(region: Region, kind: int) -> tuple[list[Interval], list[list[Interval]]]:
    """Return a gain at the corners of its weights in order, and its rises along each weight."""
    table = region.gains[kind]
    corners = sorted(table)
    rises = [
        [
            point(table[corner] - table[corner[:i] + (0,) + corner[i + 1 :]])
            for corner in corners
            if corner[i] == 1
        ]
        for i in range(len(corners[0]))
    ]
    return [point(table[corner]) for corner in corners], rises


def _corner_range(values: list[Interval], weights: list[Interval]) -> Interval:
    """Return the range of what is affine in each weight, from its values at their corners."""
    if not weights:
        return values[0]
    half = len(values) // 2
    ends = []
    for w in weights[0]:
        low, high = Interval(ONE - w, ONE - w), Interval(w, w)
        pairs = zip(values[:half], values[half:], strict=True)
        ends.append(_corner_range([a * low + b * high for a, b in pairs], weights[1:]))
    return hull(*ends)


def _breaks(region: Region | None, low: Fraction, high: Fraction) -> list[Fraction]:
    """Return ``low``, the nodes of a region's table between, and ``high``."""
    nodes = region.wind if region else []
    return [low, *nodes[bisect_right(nodes, low) : bisect_left(nodes, high)], high]


@lru_cache(maxsize=64)
def _column_range(
    region: Region, name: str, low: Fraction, high: Fraction
) -> tuple[Interval, Interval]:
    """Return the ranges of a column of the trim table, and of its slope, over winds."""
    column, places = getattr(region, name), _breaks(region, low, high)
    values = [interpolated(region.wind, column, v) for v in places]
    runs = [
        (b - a) / (last - first)
        for first, last, a, b in zip(places, places[1:], values, values[1:], strict=False)
        if last > first
    ] or [Fraction(0)]
    return enclose(min(values), max(values)), enclose(min(runs), max(runs))


@lru_cache(maxsize=64)
def _held_trim(region: Region, wind: Fraction) -> tuple[Fraction, Fraction]:
    """Return a wind, held within the trim table, and the table's rotor speed there."""
    held = min(max(wind, region.wind[0]), region.wind[-1])
    return held, interpolated(region.wind, region.speed, wind)


def interpolated(wind: list[Fraction], column: list[Fraction], at: Fraction) -> Fraction:
    """Return a column of a table at a wind: linear between nodes, held beyond them."""
    v = min(max(at, wind[0]), wind[-1])
    k = min(bisect_right(wind, v), len(wind) - 1) - 1
    return column[k] + (v - wind[k]) / (wind[k + 1] - wind[k]) * (column[k + 1] - column[k])


def jacobians(
    plant: Plant, law: PublishedLaw, overlaps: Overlaps, ends: Ends
) -> list[list[list[Interval]]]:
    """Return matrices whose hull holds every Jacobian of the loop in units of the box [1/s].

    Raises
    ------
    Refused : a range that leaves the torque table, or more than the pitch rate limit demanded.
    """
    loop, per_width = (
        Loop(plant, law, overlaps, ends, "states"),
        [point(1 / r) for r in ends.widths],
    )
    return [
        [
            [slope * factor for slope in rate.slopes]
            for rate, factor in zip(loop.rates(*choice), per_width, strict=True)
        ]
        for choice in loop.choices()
    ]


def field_at_centre(plant: Plant, law: PublishedLaw, overlaps: Overlaps, ends: Ends) -> list[int]:
    """Return bounds of |f_i(z_0(v), v)|, over 10^36: at the middle, and slope times half width."""
    (v1, v2), zero = ends.wind, [Fraction(0)] * STATES
    middle = [(a + b) / 2 for a, b in zip(*ends.states, strict=True)]
    halfway = (v1 + v2) / 2
    at_middle = Loop(plant, law, overlaps, Ends((halfway, halfway), (middle, middle), zero), "none")
    along = Loop(plant, law, overlaps, Ends((v1, v2), ends.states, zero), "line")
    half = point((v2 - v1) / 2)
    return [
        here.value.magnitude() + (Interval(0, line.slopes[0].magnitude()) * half).high
        for here, line in zip(at_middle.rates(), along.rates(), strict=True)
    ]
