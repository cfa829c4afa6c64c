r"""Steady operation over wind: reference speed, torque and pitch in the regions 1.5, 2, 2.5, 3.

    region   speed                          pitch                   torque
    1.5      minimum                        smallest                balances T_r
    2        lambda_opt v / R               smallest                balances T_r
    2.5      set-point                      smallest                balances T_r
    3        set-point                      balances T_r            rated

with balance T_r(omega, beta, v) = n_g T_g.  lambda_opt is the maximiser of lambda c_Q at smallest
pitch.  The minimum speed is given up below about 3.5 m/s, where it would drive lambda to the
table's end: lambda stays at or below ``TABLE_SHARE`` of the largest tip-speed ratio of the table,
so that a band of speeds around the trim still lies inside.

De-rated operation: the same turbine with a lower torque set-point.

Full load holds a torque T_set below rated, so that the power above the (lower) rated wind is

    P = efficiency * T_set * n_g * omega_set,

at rated speed the share T_set / T_rated of rated power; ``speed_setpoint`` of ``trim`` and of the
laws lowers the other factor.  The rotor, its tables and its actuators stay what they are: only the
torque at which partial load ends moves, and with it trim, schedule, laws and certificate.

A torque below that of the best tip-speed ratio at omega_set, K (n_g omega_set)^2, would be reached
before the speed is, and a little above it pitch still raises torque where full load begins.  Both
are refused; such a torque needs a lower speed set-point.

The frozen wake's pitch effectiveness stays the published column over wind, which was computed at
rated power; at the same wind a de-rated rotor is pitched further.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, degrees, floor, isfinite, pi, radians
from types import MappingProxyType

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.turbine.data import Figure, Turbine, rotor_torque, rotor_torque_gradient

TABLE_SHARE = 0.9
# Steps of wind and pitch, small enough to find the sign change that Brent's method refines.
WIND_STEPS = 221
PITCH_STEPS = 301
# Smallest pitches that are tried where the rotor is stalled at rated wind [rad].
PITCH_STEP, LARGEST_LEAST = radians(0.25), radians(8)
EXTEND = "extend the coefficient tables, or leave this wind out by cut_in and cut_out"


class SmallestPitchError(ModelError):
    """At rated wind the rotor does not shed torque by pitching up from the smallest pitch.

    Attributes
    ----------
    least_pitch : a smallest pitch [rad] with which it does; None where none was seen.
    """

    def __init__(self, message: str, least_pitch: float | None = None) -> None:
        super().__init__(message)
        self.least_pitch = least_pitch


@dataclass(frozen=True, slots=True)
class TrimPoint:
    """A steady state: wind [m/s], rotor speed [rad/s], pitch [rad], torque [N m], region.

    ``torque`` is the generator's, on the high-speed shaft; ``region`` is "1.5", "2", "2.5" or "3".
    """

    wind: float
    rotor_speed: float
    pitch: float
    torque: float
    region: str


@lru_cache(maxsize=32)
def optimal_tip_speed_ratio(turbine: Turbine) -> float:
    """Return argmax of lambda c_Q(lambda, smallest pitch) [-]."""
    from scipy.optimize import brentq

    low, high = turbine.torque.x_range
    ratios = np.linspace(low, high, 501)
    best = int(np.argmax(ratios * turbine.torque(ratios, turbine.pitch_min)))
    # A maximum at the end of the grid says that the true one may lie outside the table.
    if best in (0, len(ratios) - 1):
        raise ModelError(
            f"{turbine.name}: power at smallest pitch still rises at the table's end, tip-speed "
            f"ratio {ratios[best]:.3g}; extend the coefficient tables"
        )

    def slope(ratio: float) -> float:
        c_q = turbine.torque(ratio, turbine.pitch_min)
        return float(c_q + ratio * turbine.torque(ratio, turbine.pitch_min, dx=1))

    return float(brentq(slope, ratios[best - 1], ratios[best + 1], xtol=1e-13))


def optimal_torque_constant(turbine: Turbine) -> float:
    """Return K with T_g = K w_g^2 in region 2: rho pi R^5 c_Q / (2 lambda^2 n_g^3) [N m s^2/rad^2].

    High-speed shaft, at the optimal tip-speed ratio of the table and smallest pitch.
    """
    ratio = optimal_tip_speed_ratio(turbine)
    c_q = float(turbine.torque(ratio, turbine.pitch_min))
    scale = turbine.torque_constant * turbine.rotor_radius**2
    return scale * c_q / (ratio**2 * turbine.gear_ratio**3)


def reference_speed(turbine: Turbine, wind: float, *, speed_setpoint: float | None = None) -> float:
    """Return min(max(lambda_opt v / R, minimum speed), set-point) [rad/s].

    Parameters
    ----------
    wind : from cut-in to cut-out [m/s].
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.

    Raises
    ------
    ModelError : wind outside cut-in to cut-out, or a set-point outside minimum to rated speed.
    """
    return _reference(turbine, _wind(turbine, wind), _setpoint(turbine, speed_setpoint))[0]


def rated_wind(turbine: Turbine, *, speed_setpoint: float | None = None) -> float:
    """Return the wind at which smallest pitch gives rated torque at the set-point [m/s].

    Raises
    ------
    ModelError : a set-point outside minimum to rated speed, or one at which rated torque is not
        reached up to cut-out, or at which pitching up would *raise* torque there (stall side).
    """
    setpoint = _setpoint(turbine, speed_setpoint)
    wind = _rated_wind(turbine, setpoint)
    if wind is None:
        raise ModelError(
            f"{turbine.name}: at rotor speed {setpoint:.4g} rad/s the rotor does not reach rated "
            f"torque {turbine.rated_torque:.6g} N m at any wind up to {turbine.cut_out:.4g} m/s; "
            "raise the set-point"
        )
    return wind


def trim(turbine: Turbine, wind: float, *, speed_setpoint: float | None = None) -> TrimPoint:
    """Return the steady state at a constant wind.

    Parameters
    ----------
    wind : from cut-in to cut-out [m/s].
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.  Torque in region 3
        stays at its rated value, so that a lower set-point lowers power in proportion.

    Raises
    ------
    ModelError : wind outside cut-in to cut-out, a set-point outside minimum to rated speed, or no
        steady state at this wind; the message names the wind and what to change.
    """
    v = _wind(turbine, wind)
    setpoint = _setpoint(turbine, speed_setpoint)
    speed, region = _reference(turbine, v, setpoint)
    limit = _rated_wind(turbine, setpoint)
    if limit is not None and v >= limit:
        return TrimPoint(v, setpoint, _pitch(turbine, setpoint, v), turbine.rated_torque, "3")
    try:
        torque = float(rotor_torque(turbine, speed, turbine.pitch_min, v)) / turbine.gear_ratio
    except ModelError as error:
        raise _infeasible(turbine, speed, v, str(error), EXTEND) from error
    if not 0 < torque <= turbine.maximum_torque:
        why = f"the balancing torque would be {torque:.6g} N m"
        raise _infeasible(turbine, speed, v, why, "leave this wind out by cut_in and cut_out")
    return TrimPoint(v, speed, turbine.pitch_min, torque, region)


def _wind(turbine: Turbine, wind: float) -> float:
    if not turbine.cut_in <= wind <= turbine.cut_out:
        raise ModelError(
            f"{turbine.name}: a steady state at wind {wind:.6g} m/s is needed; it exists from "
            f"cut-in {turbine.cut_in:.6g} to cut-out {turbine.cut_out:.6g} m/s"
        )
    return float(wind)


def _setpoint(turbine: Turbine, speed_setpoint: float | None) -> float:
    if speed_setpoint is None:
        return turbine.rated_rotor_speed
    low, high = turbine.minimum_rotor_speed, turbine.rated_rotor_speed
    if not low < speed_setpoint <= high:
        raise ModelError(
            f"{turbine.name}: speed set-point {speed_setpoint:.6g} rad/s was given; it must lie "
            f"above the minimum {low:.6g} and at or below the rated {high:.6g} rad/s"
        )
    return float(speed_setpoint)


def _reference(turbine: Turbine, v: float, setpoint: float) -> tuple[float, str]:
    """Return the speed and the region it belongs to, region 3 left out."""
    per_ratio = v / turbine.rotor_radius
    optimal = optimal_tip_speed_ratio(turbine) * per_ratio
    ceiling = TABLE_SHARE * turbine.torque.x_range[1] * per_ratio
    minimum = min(turbine.minimum_rotor_speed, ceiling)
    if optimal >= setpoint:
        return setpoint, "2.5"
    if optimal <= minimum:
        return minimum, "1.5"
    return optimal, "2"


@lru_cache(maxsize=64)
def _rated_wind(turbine: Turbine, setpoint: float) -> float | None:
    """Return the lowest wind with rated torque at smallest pitch, or None if none exists."""
    v = _balance(turbine, setpoint)
    if v is not None:
        _check_sheds(turbine, setpoint, v)
    return v


def _balance(turbine: Turbine, setpoint: float) -> float | None:
    """Return ``_rated_wind``, be it on the stall side or not."""
    from scipy.optimize import brentq

    needed = turbine.gear_ratio * turbine.rated_torque

    def excess(v: float) -> float:
        speed, _ = _reference(turbine, v, setpoint)
        return float(rotor_torque(turbine, speed, turbine.pitch_min, v)) - needed

    low_ratio = turbine.torque.x_range[0]
    last = min(turbine.cut_out, setpoint * turbine.rotor_radius / low_ratio)
    # Brent's method needs a bracket, and the lowest one is rated wind: above it pitch acts, and the
    # balance at smallest pitch has no meaning.
    winds = np.linspace(turbine.cut_in, last, WIND_STEPS)
    for below, above in zip(winds, winds[1:], strict=False):
        if excess(above) >= 0:
            return float(brentq(excess, below, above, xtol=1e-12))
    return None


def _check_sheds(turbine: Turbine, setpoint: float, v: float) -> None:
    """Refuse a turbine that has its rated torque too early, or stalled, where region 3 begins."""
    speed, by_pitch = _at_rated(turbine, setpoint, v)
    if speed == setpoint and by_pitch < 0:
        return
    remedies = ["raise rated torque or lower rated speed"] if speed < setpoint else []
    least_pitch = _least_pitch(turbine, setpoint)
    if least_pitch is not None:
        remedies.insert(0, f"give {degrees(least_pitch):.4g} deg or more as pitch.minimum")
    if speed < setpoint:
        speed_name = "the set-point" if setpoint < turbine.rated_rotor_speed else "rated speed"
        raise SmallestPitchError(
            f"{turbine.name}: rated torque {turbine.rated_torque:.6g} N m is reached at {v:.4g} "
            f"m/s, where the rotor turns at {speed:.4g} rad/s, before {speed_name}, {setpoint:.4g} "
            f"rad/s; {', or '.join(remedies)}",
            least_pitch,
        )
    refusal = _infeasible(
        turbine,
        setpoint,
        v,
        f"this is rated wind, and pitching up from the smallest pitch, "
        f"{degrees(turbine.pitch_min):.4g} deg, would raise torque (dT/dpitch = "
        f"{by_pitch:.4g} N m/rad): the rotor is on its stall side there",
        (
            ", or ".join(remedies)
            or "correct rated torque, rated speed or the power coefficients there"
        )
        + _or_setpoint(turbine, setpoint),
    )
    raise SmallestPitchError(str(refusal), least_pitch)


def _at_rated(turbine: Turbine, setpoint: float, v: float) -> tuple[float, float]:
    """Return the rotor speed [rad/s] and dT/dpitch [N m/rad] where rated torque is reached."""
    speed, _ = _reference(turbine, v, setpoint)
    slope = rotor_torque_gradient(turbine, setpoint, turbine.pitch_min, v, clip=True)[1]
    return speed, float(slope)


def _least_pitch(turbine: Turbine, setpoint: float) -> float | None:
    """Return a smallest pitch [rad] with which pitch sheds torque at rated wind, by trying."""
    largest_pitch = min(LARGEST_LEAST, turbine.torque.y_range[1], turbine.pitch_max)
    for step in range(floor(turbine.pitch_min / PITCH_STEP) + 1, round(largest_pitch / PITCH_STEP)):
        trial = replace(turbine, pitch_min=step * PITCH_STEP)
        v = _balance(trial, setpoint)
        if v is None:
            return None
        speed, by_pitch = _at_rated(trial, setpoint, v)
        if speed == setpoint and by_pitch < 0:
            return trial.pitch_min
    return None


def _pitch(turbine: Turbine, speed: float, v: float) -> float:
    """Return the largest pitch that balances rated torque: the feather side of the hill."""
    from scipy.optimize import brentq

    needed = turbine.gear_ratio * turbine.rated_torque
    cure = EXTEND + _or_setpoint(turbine, speed)
    last = min(turbine.pitch_max, turbine.torque.y_range[1])
    pitches = np.linspace(turbine.pitch_min, last, PITCH_STEPS)
    try:
        excess = rotor_torque(turbine, speed, pitches, v) - needed
    except ModelError as error:
        raise _infeasible(turbine, speed, v, str(error), cure) from error
    if excess[-1] > 0:
        why = f"the largest pitch of the table, {last:.4g} rad, still leaves too much torque"
        raise _infeasible(turbine, speed, v, why, cure)
    above = np.flatnonzero(excess > 0)
    if len(above) == 0:
        # At rated wind itself rounding may place the balance slightly below smallest pitch.
        if excess[0] > -1e-9 * needed:
            return float(pitches[0])
        raise _infeasible(turbine, speed, v, "no pitch gives rated torque", cure)

    def balance(pitch: float) -> float:
        return float(rotor_torque(turbine, speed, pitch, v)) - needed

    # The last sign change: at a smaller pitch the balance may also hold, but with a stalled rotor.
    first = int(above[-1])
    return float(brentq(balance, pitches[first], pitches[first + 1], xtol=1e-14))


def _or_setpoint(turbine: Turbine, setpoint: float) -> str:
    """Return a further cure, where a lower set-point than the rated speed was given."""
    rated = turbine.rated_rotor_speed
    return f", or raise the speed set-point (at most {rated:.6g} rad/s)" if setpoint < rated else ""


def _infeasible(turbine: Turbine, speed: float, v: float, why: str, cure: str) -> ModelError:
    return ModelError(
        f"{turbine.name}: no steady state at wind {v:.6g} m/s and rotor speed {speed:.6g} rad/s: "
        f"{why}; {cure}"
    )


RATED = "generator.rated_torque"
SCAN_STEPS, BISECTIONS = 20, 8


def derated(
    turbine: Turbine, torque_setpoint: float | None, *, speed_setpoint: float | None = None
) -> Turbine:
    """Return the turbine that holds ``torque_setpoint`` where it held its rated torque.

    Parameters
    ----------
    torque_setpoint : [N m], high-speed shaft; None, or the rated torque itself, changes nothing.
    speed_setpoint : omega_set [rad/s] of the de-rated operation; None takes the rated speed.

    Raises
    ------
    ModelError : a set-point that is not above 0 and at most the rated torque, or one that is
        reached before the speed set-point; says the least torque and the largest speed that fit.
    """
    rated = turbine.rated_torque
    if torque_setpoint is None or torque_setpoint == rated:
        return turbine
    if not (isfinite(torque_setpoint) and 0 < torque_setpoint < rated):
        raise ModelError(
            f"{turbine.name}: torque set-point {torque_setpoint:.6g} N m was given; it must lie "
            f"above 0 and at or below the rated torque, {rated:.6g} N m on the high-speed shaft"
        )
    speed = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    if not _fits(turbine, torque_setpoint, speed):
        raise _too_early(turbine, torque_setpoint, speed)
    return _lowered(turbine, torque_setpoint)


def _lowered(turbine: Turbine, torque: float) -> Turbine:
    source = f"torque set-point, {100 * torque / turbine.rated_torque:.4g} % of rated"
    figures = {**turbine.figures, RATED: Figure(torque, "N m", source)}
    return replace(turbine, rated_torque=torque, figures=MappingProxyType(figures))


def _fits(turbine: Turbine, torque: float, speed: float) -> bool:
    """Return whether the speed is reached first, and pitch then sheds what is too much."""
    if torque < optimal_torque_constant(turbine) * (turbine.gear_ratio * speed) ** 2:
        return False
    try:
        rated_wind(_lowered(turbine, torque), speed_setpoint=speed)
    except ModelError:
        return False
    return True


def _too_early(turbine: Turbine, torque: float, speed: float) -> ModelError:
    """Return words with the least torque and the largest speed that fit."""
    rated, low = turbine.rated_torque, turbine.minimum_rotor_speed
    least_torque = _edge(lambda value: _fits(turbine, value, speed), torque, rated)
    # Slightly above the minimum, which is itself refused as a set-point.
    slowest = low + 1e-3 * (speed - low)
    fitting = _edge(lambda value: _fits(turbine, torque, value), speed, slowest)
    remedies = []
    if least_torque is not None:
        remedies.append(
            f"raise the torque to {least_torque:.6g} N m "
            f"({ceil(1000 * least_torque / rated) / 10:g} %)"
        )
    if fitting is not None:
        rpm = floor(fitting * 3000 / pi) / 100
        remedies.append(f"lower the speed set-point to {rpm:g} rpm or less")
    remedy = " or ".join(remedies) or "leave the torque at its rated value"
    return ModelError(
        f"{turbine.name}: torque set-point {torque:.6g} N m ({100 * torque / rated:.3g} % of "
        f"rated) was given with rotor speed {speed:.4g} rad/s; the rotor reaches that torque "
        f"before, or just when, it reaches that speed, where pitch cannot shed yet: {remedy}"
    )


def _edge(holds: Callable[[float], bool], without: float, towards: float) -> float | None:
    """Return the number closest to ``without`` at which it holds, found by bisection."""
    steps = [without + (towards - without) * k / SCAN_STEPS for k in range(SCAN_STEPS + 1)]
    first = next((k for k in range(1, SCAN_STEPS + 1) if holds(steps[k])), None)
    if first is None:
        return None
    bad, good = steps[first - 1], steps[first]
    for _ in range(BISECTIONS):
        middle = (bad + good) / 2
        bad, good = (bad, middle) if holds(middle) else (middle, good)
    return good
