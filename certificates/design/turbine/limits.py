"""Checks the limits of the design settings of a turbine before the long work begins."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.turbine.aerodynamics import rotor_torque, rotor_torque_gradient
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint, rated_wind, trim

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.settings import DesignSettings

# A command limited at rated torque must not be rounded off below half of rated torque.
LARGEST_SHARE = 0.5
WIND_STEPS = 201
# Least d ln T_r / d ln v at a trim [-].  It is 2 where c_Q is constant, and 0 where c_Q grows with
# the square of the tip-speed ratio.
LEAST_EXPONENT = 0.05
WIND_STEP = 0.5  # m/s, between the winds at which the trim is checked


def check_limits(turbine: Turbine, asked: DesignSettings) -> None:
    """Refuse overlaps and a bandwidth for which the law cannot work.

    both        a steady state at every wind from cut-in to cut-out, at which more wind gives more
                torque, or it cannot be observed
    coherent    overlap < n_g T_rated / J, the effort that torque can hold in reserve, and
                bandwidth, grown too, <= 1 / tau, the rate of the pitch drive
    published   torque overlap below half of rated torque, its rounded corner below the largest
                torque; the ramp of f_1 above the smallest speed; and, with one integrator,
                f_1 > 0 at the set-point, or nothing acts above rated wind

    Raises
    ------
    ModelError : one of them fails; says what was given, what is needed, at which winds, and a
        number that works.
    """
    _check_rated_torque(turbine, asked.speed_setpoint)
    _check_trims(turbine, asked.speed_setpoint)
    if asked.law == "coherent":
        _check_overlap(turbine, asked.overlap)
        if asked.effort is not None:
            _check_bandwidth(turbine, asked.effort.bandwidth, asked.effort.bandwidth_growth)
        return
    _check_torque_overlap(turbine, asked.torque_overlap)
    _check_speed_ramp(turbine, asked)


def _check_rated_torque(turbine: Turbine, setpoint: float | None) -> None:
    """Refuse a rated torque that is not reached at smallest pitch at any wind inside the table."""
    speed = setpoint or turbine.rated_rotor_speed
    least = speed * turbine.rotor_radius / turbine.torque.x_range[1]
    last = speed * turbine.rotor_radius / turbine.torque.x_range[0] * (1 - 1e-9)
    # Just inside the table's ends, where rounding could leave it.
    first = max(least * (1 + 1e-9), turbine.cut_in)
    winds = np.linspace(first, min(last, turbine.cut_out), WIND_STEPS)
    found = rotor_torque(turbine, speed, turbine.pitch_min, winds) / turbine.gear_ratio
    low, high = float(found[0]), float(found.max())
    if not low < turbine.rated_torque <= high:
        raise ModelError(
            f"{turbine.name}: rated torque {turbine.rated_torque:.6g} N m was given; at "
            f"{speed:.4g} rad/s and smallest pitch the rotor gives {low:.6g} N m at "
            f"{winds[0]:.4g} m/s, where the table begins, and at most {high:.6g} N m, at "
            f"{float(winds[int(found.argmax())]):.4g} m/s; rated torque must lie between these two"
        )


def _check_trims(turbine: Turbine, setpoint: float | None) -> None:
    """Refuse a turbine without a steady state somewhere between cut-in and cut-out."""
    good: list[float] = []
    for v in np.arange(turbine.cut_in, turbine.cut_out + WIND_STEP / 2, WIND_STEP):
        wind = min(float(v), turbine.cut_out)
        try:
            point = trim(turbine, wind, speed_setpoint=setpoint)
        except ModelError as error:
            held = f"it exists from {good[0]:.4g} to {good[-1]:.4g} m/s" if good else "none exists"
            raise ModelError(
                f"{error}. A steady state is needed from cut-in {turbine.cut_in:.4g} to cut-out "
                f"{turbine.cut_out:.4g} m/s; {held}, looked at in steps of {WIND_STEP:g} m/s: give "
                "such winds as cut_in and cut_out, or change the torque and pitch limits"
            ) from error
        _check_observed(turbine, point)
        good.append(wind)


def _check_observed(turbine: Turbine, point: TrimPoint) -> None:
    """Refuse a trim at which the wind hardly changes the torque: a = d ln T_r / d ln v."""
    slope = float(
        rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, point.wind, clip=True)[2]
    )
    torque = turbine.gear_ratio * point.torque
    if slope * point.wind < LEAST_EXPONENT * torque:
        ratio = point.rotor_speed * turbine.rotor_radius / point.wind
        raise ModelError(
            f"{turbine.name}: at {point.wind:.4g} m/s 1 % more wind gives only "
            f"{slope * point.wind / torque:.3g} % more torque (tip-speed ratio {ratio:.4g}, pitch "
            f"{math.degrees(point.pitch):.4g} deg), and at least {LEAST_EXPONENT:g} % is needed: "
            "the observer cannot see the wind there; correct the power coefficients around this "
            "place, raise the speed set-point, or leave this wind out by cut_in and cut_out"
        )


def _check_overlap(turbine: Turbine, overlap: float) -> None:
    reserve = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    if not 0 < overlap < reserve:
        raise ModelError(
            f"overlap {overlap:.4g} rad/s^2 was given; above 0 and below {reserve:.4g} rad/s^2 is "
            "needed, the whole effort of rated torque: a wider ramp gives pitch a share of it at "
            f"every wind from cut-in, {turbine.cut_in:.4g} m/s, on; try {_short(reserve / 10)}"
        )


def _check_bandwidth(turbine: Turbine, bandwidth: float, growth: float) -> None:
    drive = 1 / turbine.pitch_time_constant
    if 0 < bandwidth <= drive < bandwidth * growth:
        raise ModelError(
            f"bandwidth growth {growth:.4g} was given with a bandwidth of {bandwidth:.4g} 1/s; at "
            f"most {drive:.4g} 1/s is needed, the rate of the pitch drive, at all winds: try "
            f"{_short(drive / bandwidth / 2)}"
        )
    if not 0 < bandwidth <= drive:
        raise ModelError(
            f"bandwidth {bandwidth:.4g} 1/s was given; above 0 and at most {drive:.4g} 1/s is "
            "needed, the rate of the pitch drive, which acts at all winds above rated, "
            f"{rated_wind(turbine):.4g} m/s; try {_short(drive / 8)}"
        )


def _check_torque_overlap(turbine: Turbine, overlap: float) -> None:
    rated, largest = turbine.rated_torque, turbine.maximum_torque
    most = min(LARGEST_SHARE * rated, 2 * (largest - rated))
    if not 0 < overlap <= most:
        raise ModelError(
            f"torque overlap {overlap:.6g} N m was given; above 0 and at most {most:.6g} N m is "
            f"needed: it rounds the corner at rated torque, {rated:.6g} N m, up to half of it "
            f"higher, and the largest torque is {largest:.6g} N m; at rated wind, "
            f"{rated_wind(turbine):.4g} m/s, a wider one leaves no torque that is held; try "
            f"{_short(most / 4)}"
        )


def _check_speed_ramp(turbine: Turbine, asked: DesignSettings) -> None:
    setpoint = asked.speed_setpoint or turbine.rated_rotor_speed
    placement, overlap = asked.ramp_placement, asked.speed_overlap
    room = setpoint - turbine.minimum_rotor_speed
    below = (1 - placement) * overlap
    if below >= room:
        raise ModelError(
            f"speed overlap {overlap:.4g} rad/s was given, {below:.4g} rad/s of it below the "
            f"set-point; less than {room:.4g} rad/s is needed there: the ramp would begin below "
            f"the smallest speed, {turbine.minimum_rotor_speed:.4g} rad/s, and pitch would act at "
            f"every wind from {turbine.cut_in:.4g} m/s on; try {_short(setpoint / 12)}"
        )
    if placement * overlap > room:
        raise ModelError(
            f"speed overlap {overlap:.4g} rad/s was given, {placement * overlap:.4g} rad/s of it "
            f"above the set-point; at most {room:.4g} rad/s is needed there, or pitch acts fully "
            f"at no speed that the rotor should reach; try {_short(setpoint / 12)}"
        )
    if asked.law == "paper" and placement >= 1:
        rated = rated_wind(turbine, speed_setpoint=asked.speed_setpoint)
        raise ModelError(
            f"ramp placement {placement:.4g} was given; below 1 is needed for the published "
            "law: at the set-point torque is held at rated and f_1 is 0, so that no actuator "
            f"acts; the loop has no equilibrium at {rated:.4g} to {turbine.cut_out:.4g} m/s; "
            "try 0.5"
        )


def _short(value: float) -> str:
    return f"{value:.2g}" if value < 100 else f"{float(f'{value:.2g}'):.0f}"
