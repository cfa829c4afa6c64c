r"""Rigorous enclosures of the slopes of T_r / J, and of the slopes' own gradients.

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

from fractions import Fraction
from functools import lru_cache
from typing import Literal, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.turbine.data import Turbine

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
    """Return lambda, beta (rounding kept inside the table) and S.

    Raises
    ------
    ModelError : they are not in the table; says which entries it lacks, and at which wind.
    """
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
    radius = exact(turbine.rotor_radius)
    at_rotor = exact(turbine.gear_ratio) ** 2 * exact(turbine.generator_inertia)
    inertia = exact(turbine.rotor_inertia) + at_rotor
    return PI * (exact(turbine.air_density) * radius**3 / (2 * inertia))
