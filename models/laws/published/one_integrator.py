r"""Rest points of law ``paper``: omega = omega_ref, and one balance over pitch; see
``equilibrium`` for the formulas.
"""

from __future__ import annotations

import numpy as np

from takagi.models.laws.published.equilibrium_point import (
    Equilibrium,
    LawFigures,
    first_root,
    highest_pitch,
    named,
    no_equilibrium,
    rotor_torque_over_pitch,
    torque_of,
    trim_at,
)
from takagi.models.turbine.trim import TrimPoint


def one_integrator_equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), trim_at(law, wind)
    f_1 = law.coupling.speed_ramp.at(speed)
    rotor, lowest = rotor_torque_over_pitch(law, speed, wind), law.turbine.pitch_min
    if f_1 == 0.0:
        return _torque_alone(law, wind, point, max(lowest, 0.0), f_1)

    def integral(pitch: float) -> float:
        gains = law.full.gains_at(speed, pitch, wind)
        return (1 / f_1 + gains.pitch) * pitch / gains.integral

    def torque(pitch: float) -> float:
        gain = law.partial.gains_at(speed, pitch, wind).integral
        return torque_of(law, gain * integral(pitch))

    def balance(pitch: float) -> float:
        return rotor(pitch) - torque(pitch)

    if balance(lowest) <= 0:
        return _torque_alone(law, wind, point, lowest, f_1)
    pitch = first_root(balance, lowest, highest_pitch(law))
    if np.isnan(pitch):
        return no_equilibrium(law, wind, point, f_1)
    return named(law, wind, point, f_1, speed, pitch, torque(pitch), (integral(pitch),))


def _torque_alone(
    law: LawFigures, wind: float, point: TrimPoint, pitch: float, f_1: float
) -> Equilibrium:
    """Return the equilibrium at a fixed pitch, or none where torque does not suffice."""
    speed = law.reference_speed(wind)
    needed = rotor_torque_over_pitch(law, speed, wind)(pitch)
    top = law.turbine.rated_torque + law.coupling.torque_overlap
    command = first_root(lambda u: needed - torque_of(law, u), 0.0, top)
    if np.isnan(command):
        return no_equilibrium(law, wind, point, f_1)
    x = command / law.partial.gains_at(speed, pitch, wind).integral
    return named(law, wind, point, f_1, speed, pitch, torque_of(law, command), (x,))
