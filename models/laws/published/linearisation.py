r"""The published law and its loop, linearised at the law's own equilibrium.

States (omega, beta, integrals), design model with first-order pitch drive, v_hat = v constant:

    J omega' = T_r(omega, beta, v) - n_g T,     tau_beta beta' = beta_ref - beta,     x' = law

Derivatives of the law are central differences of its blended command, scheduling included.  A
command that is held at a limit does not move; one that only just touches its limit counts as free.
Floating point: eigenvalues for tables, not a proof.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.laws.published.equilibrium import Equilibrium, equilibrium
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.aerodynamics import rotor_torque_gradient

# Steps in rotor speed [rad/s], pitch [rad], integrals [rad]. They are small against every overlap,
# and large enough that the rounding errors of the scheduled gains (1e-9 of their size) do not
# matter.
STEP = 1e-5
# A command counts as held at a limit if it exceeds it by more than this: N m and rad.
HELD = (1e-6, 1e-9)


@dataclass(frozen=True, slots=True, eq=False)
class PublishedLocalGains:
    """Derivatives of the law at an equilibrium; u = u* + torque . dz, z = (omega, beta, x).

    Attributes
    ----------
    torque : (2 + k,) dT/dz: N m s/rad, N m/rad, N m/rad per integral.
    pitch : (2 + k,) dbeta_ref/dz: s, -, - per integral.
    integrals : (k, 2 + k) dx'/dz.
    """

    torque: Floats
    pitch: Floats
    integrals: Floats


@dataclass(frozen=True, slots=True, eq=False)
class PublishedLocalLoop:
    """The closed loop at one wind: its equilibrium, its matrix, and its eigenvalues.

    Attributes
    ----------
    point : the equilibrium.
    gains : the law's derivatives there; None without an equilibrium.
    matrix : (2 + k, 2 + k), states (omega, beta, integrals); None without an equilibrium.
    eigenvalues : [1/s], slowest first; empty without an equilibrium.
    """

    point: Equilibrium
    gains: PublishedLocalGains | None
    matrix: Floats | None
    eigenvalues: Complex

    @property
    def decay_rate(self) -> float:
        """Minus the largest real part [1/s]; NaN without an equilibrium."""
        return -float(self.eigenvalues[0].real) if len(self.eigenvalues) else float("nan")

    @property
    def stable(self) -> bool:
        """Whether there is an equilibrium and all real parts are below zero."""
        return self.decay_rate > 0


def local_gains(law: PublishedLaw, point: Equilibrium) -> PublishedLocalGains:
    """Return the derivatives of the law at an equilibrium that exists.

    ``equilibrium(law, wind)`` finds one; ``local_loop`` does both.
    """
    start = np.array([point.rotor_speed, point.pitch, *point.integrals])
    at_rest = law.blended(start[2:], Measurement(point.rotor_speed, point.pitch, point.wind))
    limits = law.limited(at_rest)
    held = (
        abs(limits.torque - at_rest.blended_torque) > HELD[0],
        abs(limits.pitch - at_rest.blended_pitch) > HELD[1],
    )
    columns = []
    for k in range(len(start)):
        step = np.zeros(len(start))
        step[k] = STEP
        ahead, behind = (
            _response(law, start + sign * step, point.wind, held, limits) for sign in (1, -1)
        )
        columns.append((ahead - behind) / (2 * STEP))
    jacobian = np.stack(columns, axis=1)
    return PublishedLocalGains(jacobian[0], jacobian[1], jacobian[2:])


def local_loop(law: PublishedLaw, wind: float) -> PublishedLocalLoop:
    """Return the closed loop linearised at the law's equilibrium of a constant wind [m/s].

    Raises
    ------
    ModelError : no trim at this wind.
    """
    point = equilibrium(law, wind)
    if point.kind == "none":
        return PublishedLocalLoop(point, None, None, np.zeros(0, dtype=np.complex128))
    gains, turbine = local_gains(law, point), law.turbine
    slopes = rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, wind)
    matrix = np.zeros((2 + len(point.integrals),) * 2)
    matrix[0] = -turbine.gear_ratio / turbine.inertia * gains.torque
    matrix[0, :2] += float(slopes[0]) / turbine.inertia, float(slopes[1]) / turbine.inertia
    matrix[1] = gains.pitch / turbine.pitch_time_constant
    matrix[1, 1] -= 1 / turbine.pitch_time_constant
    matrix[2:] = gains.integrals
    eigenvalues = np.linalg.eigvals(matrix).astype(np.complex128)
    return PublishedLocalLoop(point, gains, matrix, eigenvalues[np.argsort(-eigenvalues.real)])


def _response(
    law: PublishedLaw, z: Floats, wind: float, held: tuple[bool, bool], limits: Command
) -> Floats:
    """Return (T, beta_ref, x') with held commands at their limits and the others free of them."""
    found = law.blended(z[2:], Measurement(float(z[0]), float(z[1]), wind))
    torque = limits.torque if held[0] else found.blended_torque
    pitch = limits.pitch if held[1] else found.blended_pitch
    command = Command(torque, pitch)
    if law.tracking_time is None:
        return np.array([torque, pitch, -found.error])
    return np.array([torque, pitch, *law.tracking_rate(found, command)])
