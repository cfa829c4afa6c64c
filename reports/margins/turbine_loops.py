"""The turbine linearised at a trim, and its loops, each broken at its actuator.

    omega' = a omega + b beta + d (v - x') - (n_g/J) T_g
    m x''  = F_omega omega + F_beta beta + F_v (v - x') - c x' - k x      (tower, optional)
    tau beta' = beta_ref - beta     or     beta'' = w^2 (beta_ref - beta) - 2 zeta w beta'

all deviations from the trim; x is the fore-aft motion of the tower top.  Measured are the rotor
speed, through a one-pole filter if asked, and pitch.  Each command passes a pure delay, replaced
by a Pade approximation.

Source: Jonkman et al. (2009), NREL/TP-500-38060, for the lags; Franklin, Powell & Workman (1998),
Digital Control of Dynamic Systems, for the half sample that a zero-order hold costs.

With the plant y = P u, y = (omega, beta), u = (T_g, beta_ref), and the law u = C y, the loop at
both actuators is L = -C P (negative feedback).  Breaking one with the other closed gives the
scalar loops; all three are built in state space, so that their closed-loop poles are the same.

A law is given by its partial derivatives at the trim, with x_I' = omega_ref - omega:

    T_g      = k_Tw omega + k_TI x_I
    beta_ref = k_bw omega + k_bb beta + k_bI x_I
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.models.turbine.aerodynamics import rotor_torque_gradient, tip_speed_ratio
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint

if TYPE_CHECKING:
    from control import StateSpace

# Order 2 is exact to 1e-4 rad up to a phase lag of 0.9 rad: at 30 ms, up to 5 Hz.
PADE_ORDER = 2


@dataclass(frozen=True, slots=True)
class FirstOrderDrive:
    """tau beta' = beta_ref - beta, with tau [s]."""

    time_constant: float


@dataclass(frozen=True, slots=True)
class SecondOrderDrive:
    """beta'' = w^2 (beta_ref - beta) - 2 zeta w beta', with w [rad/s] and zeta [-]."""

    frequency: float
    damping: float


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
    """
    import control

    core = control.ss(*_core(speed, pitch, wind, torque, drive, tower))
    if speed_filter is not None:
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


Plant = Literal["design", "validation"]

# The validation plant runs its controller every 20 ms and gives the command one sample later.
SAMPLE_TIME = 0.02
COMPUTATION_DELAY = 0.02


@dataclass(frozen=True, slots=True)
class LocalGains:
    """A law's partial derivatives at a trim; signs as the law is written, u = + gain * signal.

    Attributes
    ----------
    torque_by_speed : dT_g/d omega [N m s/rad], high-speed-shaft torque by rotor speed.
    torque_by_integral : dT_g/d x_I [N m/rad], with x_I' = omega_ref - omega.
    pitch_by_speed : d beta_ref/d omega [s].
    pitch_by_pitch : d beta_ref/d beta [-].
    pitch_by_integral : d beta_ref/d x_I [-].
    """

    torque_by_speed: float = 0.0
    torque_by_integral: float = 0.0
    pitch_by_speed: float = 0.0
    pitch_by_pitch: float = 0.0
    pitch_by_integral: float = 0.0

    def controller(self) -> StateSpace:
        """Return (omega, beta) -> (T_g, beta_ref); the integrator only if something reads it."""
        import control

        D = [[self.torque_by_speed, 0.0], [self.pitch_by_speed, self.pitch_by_pitch]]
        if self.torque_by_integral == 0 and self.pitch_by_integral == 0:
            return control.ss([], [], [], D)
        C = [[self.torque_by_integral], [self.pitch_by_integral]]
        return control.ss([[0.0]], [[-1.0, 0.0]], C, D)


@dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """The loops of one trim under negative feedback, python-control state spaces.

    Attributes
    ----------
    torque, pitch : scalar loops, broken at one actuator, the other closed.
    both : 2 x 2, broken at both; order torque, pitch.
    poles : of the closed loop [1/s], by real part, slowest first.
    """

    torque: StateSpace
    pitch: StateSpace
    both: StateSpace
    poles: Complex

    @property
    def decay_rate(self) -> float:
        """-max Re(poles) [1/s]; negative for an unstable loop."""
        return float(-self.poles.real.max())


def break_loops(plant: StateSpace, controller: LocalGains | StateSpace) -> Loops:
    """Return the loops of a plant (T_g, beta_ref, ...) -> (omega, beta) and a law.

    Parameters
    ----------
    plant : as from ``linear_plant``: first two inputs torque and pitch reference, no feedthrough
        from them to the outputs.
    controller : local gains, or any state space (omega, beta) -> (T_g, beta_ref).

    Raises
    ------
    ModelError : other numbers of signals, or a feedthrough in the plant.
    """
    import control

    law = controller.controller() if isinstance(controller, LocalGains) else controller
    if (law.ninputs, law.noutputs) != (2, 2) or plant.noutputs != 2 or plant.ninputs < 2:
        raise ModelError(
            f"plant with {plant.ninputs} inputs and {plant.noutputs} outputs, law with "
            f"{law.ninputs} and {law.noutputs}; needed: plant (torque, pitch reference, ...) -> "
            "(rotor speed, pitch), law back"
        )
    both = -law * plant[:, :2]
    A, B, C, D = (np.asarray(part) for part in (both.A, both.B, both.C, both.D))
    if np.any(D):
        raise ModelError(f"the loop has feedthrough {D.tolist()}; the plant must be lagged")

    def broken(i: int) -> StateSpace:
        j = 1 - i
        return control.ss(A - B[:, [j]] @ C[[j]], B[:, [i]], C[[i]], 0.0)

    poles = np.linalg.eigvals(A - B @ C).astype(np.complex128)
    order = np.lexsort((poles.imag, -poles.real))
    return Loops(torque=broken(0), pitch=broken(1), both=both, poles=poles[order])


def plant_at_trim(
    turbine: Turbine, point: TrimPoint, *, kind: Plant = "validation", effectiveness: float = 1.0
) -> StateSpace:
    """Return the linear plant at a trim from the turbine's own figures.

    Parameters
    ----------
    kind : ``"design"``: stiff tower, first-order pitch drive, nothing else.  ``"validation"``:
        second-order drive, tower mode, speed filter, a delay of half a 20 ms sample and one sample
        of computation.
    effectiveness : factor on dT_r/d beta [-]: 1 is the quasi-steady table, the frozen-wake ratio
        the other end of the truth.

    Raises
    ------
    ModelError : unknown kind, or a trim outside the coefficient tables.
    """
    if kind not in ("design", "validation"):
        raise ModelError(f"plant kind {kind!r} was given; it is 'design' or 'validation'")
    by_speed, by_pitch, by_wind = (
        float(part) / turbine.inertia
        for part in rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, point.wind)
    )
    by_pitch *= effectiveness
    torque = turbine.gear_ratio / turbine.inertia
    if kind == "design":
        drive = FirstOrderDrive(turbine.pitch_time_constant)
        return linear_plant(
            speed=by_speed, pitch=by_pitch, wind=by_wind, torque=torque, drive=drive
        )
    return linear_plant(
        speed=by_speed,
        pitch=by_pitch,
        wind=by_wind,
        torque=torque,
        drive=SecondOrderDrive(turbine.pitch_drive_frequency, turbine.pitch_drive_damping),
        tower=_tower(turbine, point),
        speed_filter=turbine.speed_filter,
        delay=SAMPLE_TIME / 2 + COMPUTATION_DELAY,
    )


def loops_at_trim(
    turbine: Turbine,
    point: TrimPoint,
    gains: LocalGains | StateSpace,
    *,
    kind: Plant = "validation",
    effectiveness: float = 1.0,
) -> Loops:
    """Return ``break_loops(plant_at_trim(...), gains)``."""
    return break_loops(plant_at_trim(turbine, point, kind=kind, effectiveness=effectiveness), gains)


def closed_loop_poles(
    turbine: Turbine,
    points: Sequence[TrimPoint],
    gains: Sequence[LocalGains | StateSpace],
    *,
    kind: Plant = "validation",
) -> tuple[Complex, ...]:
    """Return the closed-loop poles [1/s] at each trim, slowest first."""
    return tuple(
        loops_at_trim(turbine, point, law, kind=kind).poles
        for point, law in zip(points, gains, strict=True)
    )


def _tower(turbine: Turbine, point: TrimPoint) -> Tower:
    """Derivatives of F = (k/R) v^2 c_T(lambda, beta), k = rho pi R^3 / 2, lambda = omega R / v.

    By speed k v c_T,lambda; by pitch (k/R) v^2 c_T,beta; by wind
    (k/R) v (2 c_T - lambda c_T,lambda).
    """
    ratio = float(tip_speed_ratio(turbine, point.rotor_speed, point.wind))
    at = (ratio, point.pitch)
    k, v = turbine.torque_constant, point.wind
    by_ratio = float(turbine.thrust(*at, dx=1))
    return Tower(
        mass=turbine.tower_mass,
        damping=turbine.tower_damping,
        stiffness=turbine.tower_stiffness,
        thrust_by_speed=k * v * by_ratio,
        thrust_by_pitch=k / turbine.rotor_radius * v**2 * float(turbine.thrust(*at, dy=1)),
        thrust_by_wind=k
        / turbine.rotor_radius
        * v
        * (2 * float(turbine.thrust(*at)) - ratio * by_ratio),
    )
