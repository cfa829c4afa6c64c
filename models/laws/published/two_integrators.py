r"""Rest points of law ``paper-two-integrators``: one balance over the shared speed error; see
``equilibrium`` for the formulas.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from takagi.models.laws.published.equilibrium_point import (
    Equilibrium,
    Kind,
    LawFigures,
    first_root,
    held_torque,
    highest_pitch,
    named,
    no_equilibrium,
    passing_torque,
    rotor_torque_over_pitch,
    torque_of,
    trim_at,
)
from takagi.models.turbine.trim import TrimPoint

CONTRACTIONS = 12


def two_integrators_equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), trim_at(law, wind)
    f_1, lowest = law.coupling.speed_ramp.at(speed), law.turbine.pitch_min
    passing, rotor = passing_torque(law), rotor_torque_over_pitch(law, speed, wind)
    if point.torque <= passing and point.pitch == lowest:
        kind: Kind = "intended" if f_1 < 1.0 else "continuum"
        return _resting(law, point, f_1, kind, 0.0, point.pitch, point.torque)
    if f_1 >= 1.0:
        held = held_torque(law) if rotor(lowest) >= held_torque(law) else passing
        pitch = first_root(lambda b: rotor(b) - held, lowest, highest_pitch(law))
        return _resting(law, point, f_1, "continuum", 0.0, pitch, held)

    def balance(error: float) -> float:
        pitch, command = _carried(law, speed + error, wind, error)
        return rotor_torque_over_pitch(law, speed + error, wind)(pitch) - torque_of(law, command)

    if balance(0.0) < 0:
        return _raised(law, point, f_1)
    # Beyond the ramp's end f_1 = 1 and the tracking term vanishes, so no overspeed can be at rest;
    # the pitch grows without bound there.
    last = law.coupling.speed_ramp.end - speed
    # At the end itself the pitch is infinite, so the search stops just before it.
    error = first_root(balance, 0.0, last * (1 - 1e-9))
    if np.isnan(error):
        return no_equilibrium(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error, *_carried(law, speed + error, wind, error))


def _raised(law: LawFigures, point: TrimPoint, f_1: float) -> Equilibrium:
    """Return the equilibrium below the reference speed, where ``sector`` gives more than u_1."""
    wind, speed = point.wind, law.reference_speed(point.wind)

    def error_at(command: float) -> float:
        excess, error = (command - torque_of(law, command)) / float(law.tracking_time or 0.0), 0.0
        # The gain hardly depends on the error, so this contraction settles at once.
        for _ in range(CONTRACTIONS):
            gains = law.partial.gains_at(speed + error, point.pitch, wind)
            error = excess / abs(gains.integral)
        return error

    def balance(command: float) -> float:
        rotor = rotor_torque_over_pitch(law, speed + error_at(command), wind)
        return rotor(law.turbine.pitch_min) - torque_of(law, command)

    command = first_root(balance, passing_torque(law), law.coupling.rated_torque)
    if np.isnan(command):
        return no_equilibrium(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error_at(command), law.turbine.pitch_min, command)


def _carried(law: LawFigures, speed: float, wind: float, error: float) -> tuple[float, float]:
    """Return (pitch, torque command u_1) at which both integrators rest with this error."""
    tau, highest = float(law.tracking_time or 0.0), highest_pitch(law)
    f_1 = law.coupling.speed_ramp.at(speed)
    lever = f_1 * tau * error / (1.0 - f_1) if f_1 < 1.0 else np.inf

    def pitch_gap(pitch: float) -> float:
        return pitch - lever * abs(law.full.gains_at(speed, pitch, wind).integral)

    lowest = law.turbine.pitch_min
    if pitch_gap(lowest) >= 0:
        pitch = lowest
    else:
        pitch = highest if pitch_gap(highest) <= 0 else brentq(pitch_gap, lowest, highest)
    excess = tau * error * abs(law.partial.gains_at(speed, pitch, wind).integral)
    low = held_torque(law)
    high = law.turbine.rated_torque + law.coupling.torque_overlap + excess
    if excess <= 0:
        return float(pitch), low
    return float(pitch), float(brentq(lambda u: u - torque_of(law, u) - excess, low, high))


def _resting(
    law: LawFigures,
    point: TrimPoint,
    f_1: float,
    kind: Kind | None,
    error: float,
    pitch: float,
    command: float,
) -> Equilibrium:
    """Return the equilibrium of the two integrators with the integrals that give it."""
    speed = law.reference_speed(point.wind) + error
    b = law.partial.gains_at(speed, pitch, point.wind)
    c = law.full.gains_at(speed, pitch, point.wind)
    here = law.coupling.speed_ramp.at(speed)
    pitching = here > 0 and error >= 0
    angle = pitch / here if pitching else float(law.tracking_time or 0.0) * error * abs(c.integral)
    torque = torque_of(law, command)
    integrals = (
        (command + b.speed * error + b.pitch * pitch) / b.integral,
        (angle + c.speed * error + c.pitch * pitch) / c.integral,
    )
    found = named(law, point.wind, point, f_1, speed, pitch, torque, integrals)
    if kind is None:
        return found
    return Equilibrium(point.wind, kind, speed, pitch, torque, integrals, point, f_1)
