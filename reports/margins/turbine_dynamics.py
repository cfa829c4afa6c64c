r"""The turbine linearised at a trim, with actuator, sensor and computation lags.

    omega' = a omega + b beta + d (v - x') - (n_g/J) T_g
    m x''  = F_omega omega + F_beta beta + F_v (v - x') - c x' - k x      (tower, optional)
    tau beta' = beta_ref - beta     or     beta'' = w^2 (beta_ref - beta) - 2 zeta w beta'

all deviations from the trim; x is the fore-aft motion of the tower top.  Measured are the rotor
speed, through a one-pole filter if asked, and pitch.  Each command passes a pure delay, replaced
by a Pade approximation.

Source: Jonkman et al. (2009), NREL/TP-500-38060, for the lags; Franklin, Powell & Workman (1998),
Digital Control of Dynamic Systems, for the half sample that a zero-order hold costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from control import StateSpace

# Order 2 is exact to 1e-4 rad up to a phase lag of 0.9 rad: at 30 ms, up to 5 Hz.
PADE_ORDER = 2


@dataclass(frozen=True, slots=True)
class FirstOrderDrive:
    """tau beta' = beta_ref - beta, with tau [s]."""

    time_constant: float

    def __post_init__(self) -> None:
        _positive("pitch drive", "time_constant", self.time_constant, "s")


@dataclass(frozen=True, slots=True)
class SecondOrderDrive:
    """beta'' = w^2 (beta_ref - beta) - 2 zeta w beta', with w [rad/s] and zeta [-]."""

    frequency: float
    damping: float

    def __post_init__(self) -> None:
        _positive("pitch drive", "frequency", self.frequency, "rad/s")
        _positive("pitch drive", "damping", self.damping, "-")


@dataclass(frozen=True, slots=True)
class Tower:
    """Fore-aft mode and what moves it, at a trim.

    Attributes
    ----------
    mass [kg], damping [N s/m], stiffness [N/m] : equivalent at the tower top.
    thrust_by_speed [N s/rad], thrust_by_pitch [N/rad], thrust_by_wind [N s/m] : dF at the trim.
    """

    mass: float
    damping: float
    stiffness: float
    thrust_by_speed: float
    thrust_by_pitch: float
    thrust_by_wind: float

    def __post_init__(self) -> None:
        _positive("tower", "mass", self.mass, "kg")
        _positive("tower", "stiffness", self.stiffness, "N/m")


def linear_plant(
    *,
    speed: float,
    pitch: float,
    wind: float,
    torque: float,
    drive: FirstOrderDrive | SecondOrderDrive,
    tower: Tower | None = None,
    speed_filter: float | None = None,
    delay: float = 0.0,
) -> StateSpace:
    """Return (T_g, beta_ref, v) -> (measured rotor speed, pitch) around a trim.

    Parameters
    ----------
    speed, pitch, wind : a [1/s], b [rad/s^2 per rad], d [rad/s^2 per m/s].
    torque : n_g / J [rad/s^2 per N m of generator torque].
    drive : of the pitch.
    tower : fore-aft mode; None holds the tower still.
    speed_filter : corner of the one-pole speed filter [rad/s]; None measures the speed itself.
    delay : of both commands [s]: half a sample for the hold, plus computation.  The amplitude loss
        of a hold (0.1 dB at a quarter of the Nyquist frequency) is left out.

    Returns
    -------
    control.StateSpace; inputs ``torque [N m]``, ``pitch reference [rad]``, ``wind [m/s]``, outputs
    ``rotor speed [rad/s]``, ``pitch [rad]``.

    Raises
    ------
    ModelError : a figure that is not finite, a negative delay, a filter corner not above 0.
    """
    import control

    for name, value in (("speed", speed), ("pitch", pitch), ("wind", wind), ("torque", torque)):
        if not isfinite(value):
            raise ModelError(f"coefficient {name!r} is {value}; a finite number is needed")
    if not (isfinite(delay) and delay >= 0):
        raise ModelError(f"delay {delay} s was given; a delay is 0 or more seconds")
    core = control.ss(*_core(speed, pitch, wind, torque, drive, tower))
    if speed_filter is not None:
        _positive("speed filter", "corner", speed_filter, "rad/s")
        lag = control.ss(-speed_filter, speed_filter, 1.0, 0.0)
        core = control.append(lag, _gain(1)) * core
    if delay > 0:
        late = control.ss(control.tf(*control.pade(delay, PADE_ORDER)))
        core = core * control.append(late, late, _gain(1))
    return control.ss(
        core,
        name="plant",
        inputs=["torque [N m]", "pitch reference [rad]", "wind [m/s]"],
        outputs=["rotor speed [rad/s]", "pitch [rad]"],
    )


def _gain(size: int) -> StateSpace:
    import control

    return control.ss([], [], [], np.eye(size))


def _core(
    speed: float,
    pitch: float,
    wind: float,
    torque: float,
    drive: FirstOrderDrive | SecondOrderDrive,
    tower: Tower | None,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Rotor, pitch drive and tower; states omega, beta, (beta'), (x, x')."""
    lags = 1 if isinstance(drive, FirstOrderDrive) else 2
    n = 1 + lags + (0 if tower is None else 2)
    A, B = np.zeros((n, n)), np.zeros((n, 3))
    A[0, 0], A[0, 1] = speed, pitch
    B[0] = -torque, 0.0, wind
    if isinstance(drive, FirstOrderDrive):
        A[1, 1], B[1, 1] = -1 / drive.time_constant, 1 / drive.time_constant
    else:
        A[1, 2] = 1.0
        A[2, 1:3] = -(drive.frequency**2), -2 * drive.damping * drive.frequency
        B[2, 1] = drive.frequency**2
    if tower is not None:
        # The rotor sees the wind minus the velocity of the tower's top.
        A[0, n - 1] = -wind
        A[n - 2, n - 1] = 1.0
        A[n - 1, [0, 1, n - 2]] = tower.thrust_by_speed, tower.thrust_by_pitch, -tower.stiffness
        A[n - 1, n - 1] = -tower.damping - tower.thrust_by_wind
        B[n - 1, 2] = tower.thrust_by_wind
        A[n - 1] /= tower.mass
        B[n - 1] /= tower.mass
    return A, B, np.eye(2, n), np.zeros((2, 3))


def _positive(item: str, name: str, value: float, unit: str) -> None:
    if not (isfinite(value) and value > 0):
        raise ModelError(f"{item}: {name} {value} {unit} was given; it must lie above 0")
