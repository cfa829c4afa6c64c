r"""Simulation of a rigid rotor under any law, with a pitch drive of first or second order.

    omega' = c v^2 c_Q(omega R / v, beta) - n_g T / J

    beta' = sat((beta_ref - beta)/tau)                                        first-order drive
    beta'' = w^2 (beta_ref - beta) - 2 z w beta',  |beta'| within its limit   second-order drive

The law is a function of state and wind; the wind estimate equals the wind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from takagi.certificates.campaign.spline_patches import Patches, spline_patches
from takagi.models.arrays import Floats


class TrialCommand(NamedTuple):
    """Commands of a law: torque [N m], pitch [rad]; derivatives of its own states, (m, n)."""

    torque: Floats
    pitch: Floats
    rate: Floats


# (speed, pitch, own states, wind) -> Asked
TrialLaw = Callable[[Floats, Floats, Floats, Floats], TrialCommand]


@dataclass(frozen=True, slots=True, eq=False)
class TrialRotor:
    """The plant's parameters; ``frequency`` 0 selects the first-order drive."""

    torque_scale: float
    gear_scale: float
    radius: float
    lag: float
    rate_limit: float
    pitch_min: float
    pitch_max: float
    surface: Patches
    frequency: float = 0.0
    damping: float = 0.0

    def acceleration(self, speed: Floats, pitch: Floats, wind: Floats) -> Floats:
        """Return T_r / J [rad/s^2]."""
        ratio = speed * self.radius / wind
        return np.asarray(self.torque_scale * wind**2 * self.surface(ratio, pitch))


def rotor_of(model: dict[str, Any], *, frequency: float = 0.0, damping: float = 0.0) -> TrialRotor:
    """Return the rotor of a certificate's model.

    Parameters
    ----------
    frequency [rad/s], damping [-] : of a second-order pitch drive; 0 takes the design model's.
    """
    gear = float(model["gear_ratio"])
    J = float(model["rotor_inertia"]) + gear**2 * float(model["generator_inertia"])
    table = model["torque_surface"]
    return TrialRotor(
        torque_scale=float(model["torque_constant"]) / J,
        gear_scale=gear / J,
        radius=float(model["rotor_radius"]),
        lag=float(model["pitch_time_constant"]),
        rate_limit=float(model["pitch_rate_limit"]),
        pitch_min=float(model["pitch_min"]),
        pitch_max=float(model["pitch_max"]),
        surface=spline_patches(
            table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"]
        ),
        frequency=frequency,
        damping=damping,
    )


def advance(
    rotor: TrialRotor, law: TrialLaw, state: Floats, winds: tuple[Floats, Floats, Floats], h: float
) -> tuple[Floats, TrialCommand]:
    """Return the state (omega, beta, beta', own states) h [s] later, and what was asked first.

    Parameters
    ----------
    state : (3 + m, n).
    winds : at the beginning, the middle and the end of the step [m/s].
    """
    k1, asked = _rates(rotor, law, state, winds[0])
    k2, _ = _rates(rotor, law, state + h / 2 * k1, winds[1])
    k3, _ = _rates(rotor, law, state + h / 2 * k2, winds[1])
    k4, _ = _rates(rotor, law, state + h * k3, winds[2])
    after = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    held = np.clip(after[1], rotor.pitch_min, rotor.pitch_max)
    # A pitch angle at its end stop has zero rate.
    after[2] = np.where(held == after[1], after[2], 0.0)
    after[2] = np.clip(after[2], -rotor.rate_limit, rotor.rate_limit)
    after[1] = held
    return after, asked


def _rates(
    rotor: TrialRotor, law: TrialLaw, state: Floats, wind: Floats
) -> tuple[Floats, TrialCommand]:
    speed, pitch, turning = state[:3]
    asked = law(speed, pitch, state[3:], wind)
    limit = rotor.rate_limit
    away = np.clip(asked.pitch, rotor.pitch_min, rotor.pitch_max) - pitch
    if rotor.frequency > 0:
        bent = rotor.frequency**2 * away - 2 * rotor.damping * rotor.frequency * turning
        stuck = (np.abs(turning) >= limit) & (bent * turning > 0)
        moving, bent = np.clip(turning, -limit, limit), np.where(stuck, 0.0, bent)
    else:
        moving, bent = np.clip(away / rotor.lag, -limit, limit), np.zeros_like(pitch)
    faster = rotor.acceleration(speed, pitch, wind) - rotor.gear_scale * asked.torque
    return np.concatenate([np.stack([faster, moving, bent]), asked.rate]), asked
