r"""The tube around the trim curve on which a regional model holds, and rigorous slopes over it.

The trim curve of a model is a table over the wind estimate v_0, linear between its nodes:
omega*(v_0), beta*(v_0).  It is *defined* by the decimals of the nodes, so that its range over a
piece of wind is the hull of two values, and nothing is lost between nodes.  The tube is

    |omega - omega*(v_0)| <= speed band,   |v - v_0| <= wind band,   v_0 in the wind range,
    |beta - beta*(v_0)| <= pitch band  and  smallest pitch <= beta.

Slopes of the torque are bounded over this tube, never over a rectangle lambda x beta that holds a
whole region: the rectangle contains both signs of dT_r/dbeta, the tube does not.

With S = rho pi R^3 / (2 J), lambda = omega R / v and q = c_Q(lambda, beta), T_r / J = S v^2 q and

    slope   value              d/domega            d/dbeta             d/dv
    speed   S R v q_l          S R^2 q_ll          S R v q_lb          S R (q_l - l q_ll)
    pitch   S v^2 q_b          S R v q_lb          S v^2 q_bb          S v (2 q_b - l q_lb)
    wind    S v (2 q - l q_l)  S R (q_l - l q_ll)  S v (2 q_b - l q_lb)
                                                         S (2 q - 2 l q_l + l^2 q_ll)

(l = lambda; indices l and b for derivatives by lambda and beta).  Each q is a Bernstein hull in
exact arithmetic; the turbine's figures are read as the decimals they print as, and pi is enclosed.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import IntervalBox, Range, range_over
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim

Slope: TypeAlias = Literal["speed", "pitch", "wind"]

PI = Interval(
    Fraction(3141592653589793238462643, 10**24), Fraction(3141592653589793238462644, 10**24)
)
# Arguments of the surface are rounded outward to this many decimals, or the rationals would grow.
ARGUMENT_DECIMALS = 10


def slope_enclosure(
    turbine: Turbine, slope: Slope, rotor_speed: Interval, pitch: Interval, wind: Interval
) -> Interval:
    """Return an interval that contains a partial derivative of T_r / J over the box.

    Units: 1/s (speed), 1/(s^2 rad) (pitch), 1/(s m) (wind).

    Raises
    ------
    ModelError : the box leaves the coefficient table.
    """
    ratio, angle, scale = _arguments(turbine, rotor_speed, pitch, wind)
    q = turbine.torque.bounds
    if slope == "pitch":
        return scale * wind**2 * q(ratio, angle, 0, 1)
    if slope == "speed":
        return scale * exact(turbine.rotor_radius) * wind * q(ratio, angle, 1, 0)
    return scale * wind * (2 * q(ratio, angle) - ratio * q(ratio, angle, 1, 0))


def slope_gradient(
    turbine: Turbine, slope: Slope, rotor_speed: Interval, pitch: Interval, wind: Interval
) -> tuple[Interval, Interval, Interval]:
    """Return enclosures of the slope's derivatives by rotor speed, pitch and wind over the box."""
    ratio, angle, scale = _arguments(turbine, rotor_speed, pitch, wind)
    radius = exact(turbine.rotor_radius)

    def q(dx: int, dy: int) -> Interval:
        return turbine.torque.bounds(ratio, angle, dx, dy)

    if slope == "speed":
        return (
            scale * radius**2 * q(2, 0),
            scale * radius * wind * q(1, 1),
            scale * radius * (q(1, 0) - ratio * q(2, 0)),
        )
    by_pitch_and_wind = scale * wind * (2 * q(0, 1) - ratio * q(1, 1))
    if slope == "pitch":
        return scale * radius * wind * q(1, 1), scale * wind**2 * q(0, 2), by_pitch_and_wind
    by_ratio, twice = q(1, 0), q(2, 0)
    return (
        scale * radius * (by_ratio - ratio * twice),
        by_pitch_and_wind,
        scale * (2 * q(0, 0) - 2 * ratio * by_ratio + ratio**2 * twice),
    )


def hold(angle: Interval, limits: tuple[float, float]) -> Interval:
    """Return the angles moved to the limits where they leave them."""
    low, high = exact(limits[0]), exact(limits[1])
    return Interval(min(max(angle.lower, low), high), max(min(angle.upper, high), low))


def _arguments(
    turbine: Turbine, rotor_speed: Interval, pitch: Interval, wind: Interval
) -> tuple[Interval, Interval, Interval]:
    """Return lambda, beta (rounding kept inside the table) and S."""
    radius = exact(turbine.rotor_radius)
    ratio = (rotor_speed * radius / wind).outward(ARGUMENT_DECIMALS)
    low, high = (exact(end) for end in turbine.torque.y_range)
    rounded = pitch.outward(ARGUMENT_DECIMALS)
    _require_entries(turbine, "tip-speed ratio", "", ratio, turbine.torque.x_range, wind)
    _require_entries(turbine, "pitch", " rad", pitch, turbine.torque.y_range, wind)
    angle = Interval(
        rounded.lower if pitch.lower < low else max(rounded.lower, low),
        rounded.upper if pitch.upper > high else min(rounded.upper, high),
    )
    return ratio, angle, _scale(turbine)


def _require_entries(
    turbine: Turbine,
    name: str,
    unit: str,
    needed: Interval,
    covered: tuple[float, float],
    wind: Interval,
) -> None:
    low, high = covered
    if needed.lower >= exact(low) and needed.upper <= exact(high):
        return
    winds, reached = (
        f"{float(span.lower):.4g} to {float(span.upper):.4g}" for span in (wind, needed)
    )
    raise ModelError(
        f"{turbine.name}: at winds of {winds} m/s the loop leaves the table: it may reach {name} "
        f"{reached}{unit}, and the c_P and c_T tables cover {low:.4g} to {high:.4g}{unit}; extend "
        f"the tables to that {name}, or leave these winds out by cut_in and cut_out of the "
        "turbine's file"
    )


@lru_cache(maxsize=8)
def _scale(turbine: Turbine) -> Interval:
    """Return S = rho pi R^3 / (2 J)."""
    volume = exact(turbine.rotor_radius) ** 3
    return PI * (exact(turbine.air_density) * volume / (2 * exact_inertia(turbine)))


def exact_inertia(turbine: Turbine) -> Fraction:
    """Return J = J_r + n_g^2 J_g from the decimals of the turbine's figures [kg m^2]."""
    at_rotor = exact(turbine.gear_ratio) ** 2 * exact(turbine.generator_inertia)
    return exact(turbine.rotor_inertia) + at_rotor


NODE_DECIMALS = 9
# A piece of wind [m/s] that is short enough to say what leaves the table.
SHORT = Fraction(1, 10_000)


@dataclass(frozen=True, slots=True, eq=False)
class OperatingBand:
    """A trim table and the bands around it.

    Attributes
    ----------
    wind, rotor_speed, pitch : nodes of the table [m/s, rad/s, rad], short decimals, read-only.
    speed_band, pitch_band, wind_band : half widths [rad/s, rad, m/s], exact.
    """

    turbine: Turbine
    wind: Floats
    rotor_speed: Floats
    pitch: Floats
    speed_band: Fraction
    pitch_band: Fraction
    wind_band: Fraction

    @property
    def wind_range(self) -> Interval:
        """The wind estimates covered [m/s]."""
        return Interval.of(float(self.wind[0]), float(self.wind[-1]))

    def at(self, wind_estimate: ArrayLike, *, clip: bool = False) -> tuple[Floats, Floats]:
        """Return (omega*, beta*) at wind estimates, linear between the nodes.

        Raises
        ------
        ModelError : an estimate outside the table, unless clip=True holds its ends.
        """
        v = np.asarray(wind_estimate, dtype=np.float64)
        if not clip and not np.all((v >= self.wind[0]) & (v <= self.wind[-1])):
            raise ModelError(
                f"{self.turbine.name}: wind estimate {np.min(v):.6g} to {np.max(v):.6g} m/s leaves "
                f"the model's wind range {self.wind[0]:.6g} to {self.wind[-1]:.6g} m/s; build the "
                "model for a wider one, or pass clip=True at run time"
            )
        return (
            np.asarray(np.interp(v, self.wind, self.rotor_speed)),
            np.asarray(np.interp(v, self.wind, self.pitch)),
        )


class Bands(TypedDict, total=False):
    """Half widths around the trim of a regional model; what is left out is that of ``BANDS``.

    Attributes
    ----------
    speed_band : in rotor speed [rad/s].  The default is 8 % of the 5-MW turbine's rated speed.
    pitch_band : [rad], default 2 deg; angles below the smallest pitch are not part of the band.
    wind_band : of v around its estimate [m/s].
    wind_step : distance of the trim table's nodes [m/s].
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated one.
    """

    speed_band: Number
    pitch_band: Number
    wind_band: Number
    wind_step: float
    speed_setpoint: float | None


BANDS: Bands = {"speed_band": "0.1", "pitch_band": "0.034907", "wind_band": "0.5"}


def operating_band(
    turbine: Turbine,
    wind_range: tuple[float, float],
    *,
    speed_band: Number,
    pitch_band: Number,
    wind_band: Number,
    wind_step: float = 0.25,
    speed_setpoint: float | None = None,
) -> OperatingBand:
    """Return the tube around the trim table at about ``wind_step`` over the wind range.

    Raises
    ------
    ModelError : an empty or unknown wind range, a negative band, or a tube that leaves the
        coefficient table (the message says at which wind).
    """
    low, high = wind_range
    if not turbine.cut_in <= low < high <= turbine.cut_out:
        raise ModelError(
            f"{turbine.name}: wind range {low:.6g} to {high:.6g} m/s was given; an increasing "
            f"range inside {turbine.cut_in:.6g} to {turbine.cut_out:.6g} m/s is needed"
        )
    if wind_step <= 0:
        raise ModelError(f"wind step {wind_step!r} m/s was given; a step above 0 is needed")
    bands = {"speed band": speed_band, "pitch band": pitch_band, "wind band": wind_band}
    widths = {band_name: exact(value) for band_name, value in bands.items()}
    for band_name, width in widths.items():
        if width < 0:
            raise ModelError(f"{band_name} {float(width):.6g} was given; it must not be negative")
    # A range that is a whole number of steps must not get one more piece by rounding.
    step_count = max(1, int(np.ceil((high - low) / wind_step - 1e-9)))
    winds = np.round(np.linspace(low, high, step_count + 1), NODE_DECIMALS)
    winds = np.clip(winds, turbine.cut_in, turbine.cut_out)
    points = [trim(turbine, float(v), speed_setpoint=speed_setpoint) for v in winds]
    speeds = np.round([point.rotor_speed for point in points], NODE_DECIMALS)
    # The smallest pitch stays as it is: rounded up it would not be the smallest.
    smallest = turbine.pitch_min
    pitches = np.array(
        [p.pitch if p.pitch == smallest else round(p.pitch, NODE_DECIMALS) for p in points]
    )
    for array in (winds, speeds, pitches):
        array.flags.writeable = False
    band = OperatingBand(turbine, winds, speeds, pitches, *widths.values())
    _check_inside_table(band)
    return band


def slope_range(
    band: OperatingBand, slope: Slope, *, off_trim: tuple[str, ...], tolerance: Fraction
) -> Range:
    """Return the rigorous range of a slope of T_r / J over (part of) the tube.

    ``off_trim``: which of "speed", "pitch", "wind" leave the trim curve; ``tolerance``: excess at
    each end as a share of the range's width.
    """
    offsets = tuple(
        Interval(-width, width) if band_name in off_trim else Interval(Fraction(0), Fraction(0))
        for band_name, width in (
            ("speed", band.speed_band),
            ("pitch", band.pitch_band),
            ("wind", band.wind_band),
        )
    )
    return _range_around(band.turbine, _Curve.of(band), slope, offsets, tolerance)


@lru_cache(maxsize=64)
def _range_around(
    turbine: Turbine,
    curve: _Curve,
    slope: Slope,
    offsets: tuple[Interval, ...],
    tolerance: Fraction,
) -> Range:
    """Return ``slope_range``.  It is kept: every design of a turbine asks for the same ranges."""
    boxes = [
        (Interval(first, last), *offsets)
        for first, last in zip(curve.wind, curve.wind[1:], strict=False)
    ]
    tube = _Tube(turbine, slope, curve)
    return range_over(tube.enclose_named, boxes, changes=tube.changes, tolerance=tolerance)


@dataclass(frozen=True, slots=True)
class _Curve:
    """The trim table in exact numbers: nodes of wind, rotor speed and pitch."""

    wind: tuple[Fraction, ...]
    rotor_speed: tuple[Fraction, ...]
    pitch: tuple[Fraction, ...]

    @classmethod
    def of(cls, band: OperatingBand) -> _Curve:
        columns = (band.wind, band.rotor_speed, band.pitch)
        return cls(*(tuple(exact(value) for value in column.tolist()) for column in columns))

    def over(self, interval: Interval) -> tuple[Interval, Interval]:
        """Return the ranges of omega* and beta* over a piece between two neighbouring nodes."""
        index = self._index(interval)
        ranges = []
        for column, run in zip(
            (self.rotor_speed, self.pitch), self.gradient(interval), strict=True
        ):
            ends = [
                column[index] + run * (v - self.wind[index])
                for v in (interval.lower, interval.upper)
            ]
            ranges.append(Interval(min(ends), max(ends)))
        return ranges[0], ranges[1]

    def gradient(self, interval: Interval) -> tuple[Fraction, Fraction]:
        """Return d omega*/d v_0 and d beta*/d v_0 on the piece, constant between nodes."""
        i = self._index(interval)
        step = self.wind[i + 1] - self.wind[i]
        return (
            (self.rotor_speed[i + 1] - self.rotor_speed[i]) / step,
            (self.pitch[i + 1] - self.pitch[i]) / step,
        )

    def _index(self, interval: Interval) -> int:
        return bisect_right(self.wind, interval.lower, hi=len(self.wind) - 1) - 1


@dataclass(frozen=True, slots=True, eq=False)
class _Tube:
    """One slope over boxes in the tube's own coordinates: v_0 and the errors of speed, pitch, wind.

    Rates along these coordinates know that omega*, beta* and v move together along the trim
    curve; three independent ranges would not.
    """

    turbine: Turbine
    slope: Slope
    curve: _Curve
    known_rates: dict[IntervalBox, tuple[Interval, ...]] = field(default_factory=dict)

    def enclose_named(self, box: IntervalBox) -> Interval | None:
        """Return ``enclose``; a message about the table says at which winds and what to change.

        Over a piece of wind, speed and wind need not meet at their ends, so that a tube inside the
        table may seem to leave it: None there, and shorter pieces decide.
        """
        try:
            return self.enclose(box)
        except ModelError as error:
            if box[0].width > SHORT:
                return None
            # In full load the speed is the set-point.
            full = float(max(self.curve.pitch)) > self.turbine.pitch_min
            lowered = full and float(max(self.curve.rotor_speed)) < (1 - 1e-6) * (
                self.turbine.rated_rotor_speed
            )
            raise ModelError(
                f"around the trim at wind {float(box[0].lower):.4g} to {float(box[0].upper):.4g} "
                f"m/s: {error}{', or raise the speed set-point' if lowered else ''}; from Python, "
                "narrower bands or another wind range may do"
            ) from error

    def enclose(self, box: IntervalBox) -> Interval:
        """Return the common part of the plain, mean-value and monotone enclosures."""
        enclosure = self.plain(box)
        if all(side.width == 0 for side in box):
            return enclosure
        mean_value = self.plain(tuple(Interval(side.centre, side.centre) for side in box))
        low, high = list(box), list(box)
        for index, (side, rate) in enumerate(zip(box, self.rates(box), strict=True)):
            mean_value = mean_value + rate * (side - side.centre)
            if rate.lower >= 0 or rate.upper <= 0:
                ends = Interval(side.lower, side.lower), Interval(side.upper, side.upper)
                low[index], high[index] = ends if rate.lower >= 0 else ends[::-1]
        enclosure = enclosure.intersect(mean_value)
        if low == list(box):
            return enclosure
        corners = self.plain(tuple(low)), self.plain(tuple(high))
        return enclosure.intersect(Interval(corners[0].lower, corners[1].upper))

    def changes(self, box: IntervalBox) -> list[float]:
        """Return a bound of the slope's change along each side; of wind alone beside the table."""
        try:
            rates = self.rates(box)
        except ModelError:
            return [1.0, 0.0, 0.0, 0.0]
        return [float(rate.magnitude * side.width) for rate, side in zip(rates, box, strict=True)]

    def plain(self, box: IntervalBox) -> Interval:
        return slope_enclosure(self.turbine, self.slope, *self._place(box)[0])

    def rates(self, box: IntervalBox) -> tuple[Interval, ...]:
        """Return the slope's derivatives along the four coordinates over the box.

        Where a pitch limit holds the angle, its rate is anything between free and held.
        """
        if box not in self.known_rates:
            ranges, cut = self._place(box)
            by_speed, by_pitch, by_wind = slope_gradient(self.turbine, self.slope, *ranges)
            if cut:
                by_pitch = by_pitch.hull(0)
            speed_run, pitch_run = self.curve.gradient(box[0])
            along = by_speed * speed_run + by_pitch * pitch_run + by_wind
            self.known_rates[box] = (along, by_speed, by_pitch, by_wind)
        return self.known_rates[box]

    def _place(self, box: IntervalBox) -> tuple[tuple[Interval, Interval, Interval], bool]:
        """Return rotor speed, pitch and wind over the box, and whether a pitch limit cut it."""
        estimate, speed_error, pitch_error, wind_error = box
        speed, pitch = self.curve.over(estimate)
        free = pitch + pitch_error
        limited = hold(free, (self.turbine.pitch_min, self.turbine.pitch_max))
        return (speed + speed_error, limited, estimate + wind_error), limited != free


def _check_inside_table(band: OperatingBand) -> None:
    low, high = band.turbine.torque.x_range
    e, w = float(band.speed_band), float(band.wind_band)
    radius = band.turbine.rotor_radius
    for v, speed in zip(band.wind, band.rotor_speed, strict=True):
        if v - w <= 0:
            raise ModelError(f"wind band {w:.4g} m/s reaches 0 at {v:.4g} m/s; make it narrower")
        lowest, highest = (speed - e) * radius / (v + w), (speed + e) * radius / (v - w)
        if lowest < low or highest > high:
            raise ModelError(
                f"{band.turbine.name}: at wind estimate {v:.4g} m/s the band reaches tip-speed "
                f"ratios {lowest:.4g} to {highest:.4g}, but the c_P and c_T tables cover {low:.4g} "
                f"to {high:.4g}; extend the tables to these ratios, narrow the speed band or the "
                "wind band, or leave this wind out by cut_in and cut_out of the turbine's file"
            )
