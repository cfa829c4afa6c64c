r"""De-rated operation: the same turbine with a lower torque set-point.

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
from dataclasses import replace
from math import ceil, floor, isfinite, pi
from types import MappingProxyType

from takagi.models.errors import ModelError
from takagi.models.turbine.data import Figure, Turbine
from takagi.models.turbine.trim import optimal_torque_constant, rated_wind

RATED = "generator.rated_torque"
LOOKS, BISECTIONS = 20, 8


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
    least = _edge(lambda value: _fits(turbine, value, speed), torque, rated)
    # Slightly above the minimum, which is itself refused as a set-point.
    slowest = low + 1e-3 * (speed - low)
    fitting = _edge(lambda value: _fits(turbine, torque, value), speed, slowest)
    ways = []
    if least is not None:
        ways.append(f"raise the torque to {least:.6g} N m ({ceil(1000 * least / rated) / 10:g} %)")
    if fitting is not None:
        rpm = floor(fitting * 3000 / pi) / 100
        ways.append(f"lower the speed set-point to {rpm:g} rpm or less")
    remedy = " or ".join(ways) or "leave the torque at its rated value"
    return ModelError(
        f"{turbine.name}: torque set-point {torque:.6g} N m ({100 * torque / rated:.3g} % of "
        f"rated) was given with rotor speed {speed:.4g} rad/s; the rotor reaches that torque "
        f"before, or just when, it reaches that speed, where pitch cannot shed yet: {remedy}"
    )


def _edge(holds: Callable[[float], bool], without: float, towards: float) -> float | None:
    """Return the number closest to ``without`` at which it holds, found by bisection."""
    steps = [without + (towards - without) * k / LOOKS for k in range(LOOKS + 1)]
    first = next((k for k in range(1, LOOKS + 1) if holds(steps[k])), None)
    if first is None:
        return None
    bad, good = steps[first - 1], steps[first]
    for _ in range(BISECTIONS):
        middle = (bad + good) / 2
        bad, good = (bad, middle) if holds(middle) else (middle, good)
    return good
