r"""The published laws and the effort-sharing (coherent) law, evaluated at many states at once.

Both are read from plain data, as a certificate holds it, and written from the formulas: the
published law's from docs/laws.md,

    u_1 = -k^b_w e + k^b_I x_b,    u_2 = -k^c_w e - k^c_p beta + k^c_I x_c
    T = phi(u_1) held to 0..T_rated,    beta_ref = f_1(omega) u_2 within the pitch range
    x' = -e, for two integrators plus (carried out - u)/(tau k_I)

The gains are multilinear in the premises, which are secants of T_r / J from the trim to the state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from trial_plant import TrialCommand, TrialLaw, TrialRotor

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.certificates.campaign.motion import Drive, at_wind, demanded
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Smaller steps give a secant over this width around the midpoint [rad/s, rad].
STEPS = (1e-4, 1e-4)


@dataclass(frozen=True, slots=True, eq=False)
class TrialRegion:
    """One region's schedule: trim over wind, premises' ranges, gains at their corners.

    ``gains`` : (2, 2, 3), corner in a, corner in b; k_speed, k_pitch, k_integral.
    """

    wind: Floats
    speed: Floats
    pitch: Floats
    ranges: tuple[tuple[float, float], ...]
    gains: Floats

    def blended(self, rotor: TrialRotor, speed: Floats, pitch: Floats, wind: Floats) -> Floats:
        """Return (3, n): the gains at n states."""
        v = np.clip(wind, self.wind[0], self.wind[-1])
        at_speed = np.interp(v, self.wind, self.speed)
        at_pitch = np.interp(v, self.wind, self.pitch)
        angle = pitch if len(self.ranges) > 1 else at_pitch
        steep = _secant(at_speed, speed, STEPS[0], lambda x: rotor.acceleration(x, angle, v))
        first, second = _weight(steep, self.ranges[0]), np.zeros_like(speed)
        if len(self.ranges) > 1:
            turned = _secant(
                at_pitch, pitch, STEPS[1], lambda x: rotor.acceleration(at_speed, x, v)
            )
            second = _weight(turned, self.ranges[1])
        a = np.stack([1 - first, first])
        b = np.stack([1 - second, second])
        return np.asarray(np.einsum("in,jn,ijk->kn", a, b, self.gains))


def published_trial(
    data: dict[str, Any], rotor: TrialRotor, *, ramp_start: Floats, ramp_width: Floats
) -> TrialLaw:
    """Return the published law of a certificate's ``gains``; each run has its own speed ramp.

    Raises
    ------
    ModelError : another torque filter than "saturated", or another ramp than "smooth".
    """
    coupling = data["coupling"]
    if coupling["variant"] != "saturated" or coupling["speed_ramp_shape"] != "smooth":
        raise ModelError(
            f"the law has the filter {coupling['variant']!r} with ramps "
            f"{coupling['speed_ramp_shape']!r}; trials know 'saturated' with 'smooth'"
        )
    partial, full = _region(data["partial"]), _region(data["full"])
    rated, half = float(data["rated_torque"]), float(coupling["torque_overlap"]) / 2
    tau = data.get("tracking_time")

    def law(speed: Floats, pitch: Floats, own: Floats, wind: Floats) -> TrialCommand:
        e = speed - _reference(data, rotor, wind)
        k, c = (r.blended(rotor, speed, pitch, wind) for r in (partial, full))
        u = -k[0] * e - k[1] * pitch + k[2] * own[0]
        angle = -c[0] * e - c[1] * pitch + c[2] * own[-1]
        near = np.clip(u, rated - half, rated + half)
        corner = rated - (rated + half - near) ** 2 / (4 * half)
        torque = np.maximum(np.where(u < rated - half, u, corner), 0.0)
        s = np.clip((speed - ramp_start) / ramp_width, 0.0, 1.0)
        wanted = s * s * (3 - 2 * s) * angle
        held = np.clip(wanted, float(data["pitch_min"]), float(data["pitch_max"]))
        if tau is None:
            return TrialCommand(torque, held, -e[None])
        rate = np.stack([-e + (torque - u) / (tau * k[2]), -e + (held - angle) / (tau * c[2])])
        return TrialCommand(torque, held, rate)

    return law


def effort_sharing_trial(loop: CertifiedLoop, wind_filter: float) -> TrialLaw:
    """Return a certificate's effort-sharing law with its low-pass filter; states x and v_s."""

    def law(speed: Floats, pitch: Floats, own: Floats, wind: Floats) -> TrialCommand:
        x, scheduled = own[0], np.clip(own[1], loop.wind[0], loop.wind[-1])
        cell = np.searchsorted(loop.wind[1:-1], scheduled, side="right")
        rate = (np.clip(wind, loop.wind[0], loop.wind[-1]) - scheduled) / wind_filter
        at, one = at_wind(loop, cell, scheduled), np.ones_like(x)
        drive = Drive(cell, 0 * x, rate, one, 0 * x, one)
        demand = demanded(loop, np.stack([speed, pitch, x]), at, drive)
        turn = -loop.integral_rate[cell] * (speed - at.speed)
        held = (np.abs(x) >= loop.integral_limit) & (turn * x > 0)
        torque = np.clip(demand.torque, 0.0, loop.rated_torque)
        return TrialCommand(torque, demand.pitch, np.stack([np.where(held, 0.0, turn), rate]))

    return law


def _reference(data: dict[str, Any], rotor: TrialRotor, wind: Floats) -> Floats:
    per_ratio = np.clip(wind, data["cut_in"], data["cut_out"]) / rotor.radius
    floor = np.minimum(data["minimum_rotor_speed"], data["largest_tip_speed_ratio"] * per_ratio)
    wanted = np.maximum(data["optimal_tip_speed_ratio"] * per_ratio, floor)
    return np.asarray(np.minimum(wanted, data["speed_setpoint"]))


def _region(data: dict[str, Any]) -> TrialRegion:
    premises = list(data["premises"])
    kept = [name for name in premises if name in ("a", "b")]
    places = [premises.index(name) for name in kept]
    columns = np.array([data[name] for name in ("k_speed", "k_pitch", "k_integral")]).T
    gains = np.full((2, 2, 3), np.nan)
    for rule, row in zip(data["rules"], columns, strict=True):
        i = rule[places[0]]
        for j in (0, 1) if len(places) == 1 else (rule[places[1]],):
            if not np.all(np.isnan(gains[i, j]) | (gains[i, j] == row)):
                raise ModelError("gains that depend on the premise d alone; trials know none such")
            gains[i, j] = row
    ranges = tuple((float(low), float(high)) for low, high in (data["premises"][n] for n in kept))
    wind, speed, pitch = (
        np.array(data[name], dtype=np.float64) for name in ("wind", "rotor_speed", "pitch")
    )
    return TrialRegion(wind, speed, pitch, ranges, gains)


def _secant(
    start: Floats, end: Floats, width: float, function: Callable[[Floats], Floats]
) -> Floats:
    near = np.abs(end - start) < width
    middle = (start + end) / 2
    a = np.where(near, middle - width / 2, start)
    b = np.where(near, middle + width / 2, end)
    return np.asarray((function(b) - function(a)) / (b - a))


def _weight(value: Floats, ends: tuple[float, float]) -> Floats:
    low, high = ends
    if high == low:
        return np.zeros_like(value)
    return np.asarray(np.clip((value - low) / (high - low), 0.0, 1.0))
