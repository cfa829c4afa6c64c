"""The plants that a law is run on: the rich one for validation, the stiff one of the design.

Both are values; what they do in time is in ``takagi.models.simulation.dynamics``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag
from math import inf, sqrt

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.simulation.speed_filter import SpeedFilter
from takagi.models.turbine.aerodynamics import rotor_thrust, rotor_torque
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint, trim

DRIVES = ("first-order", "second-order")
LARGEST_RIPPLE = 0.2


class Flag(IntFlag):
    """What limited the plant at a sample, or took it outside its data.

    TIP_SPEED_RATIO_CLIPPED, PITCH_OUTSIDE_TABLE : coefficients are held at the table's edge.
    PITCH_RATE_LIMITED : the drive moves as fast as it may.
    PITCH_POSITION_LIMITED : the pitch reference lies outside the pitch range.
    TORQUE_RATE_LIMITED, TORQUE_LIMITED : the torque command was not followed at once, or lies
        outside 0 to maximum torque.
    """

    TIP_SPEED_RATIO_CLIPPED = 1
    PITCH_OUTSIDE_TABLE = 2
    PITCH_RATE_LIMITED = 4
    PITCH_POSITION_LIMITED = 8
    TORQUE_RATE_LIMITED = 16
    TORQUE_LIMITED = 32


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedTurbine:
    """A turbine, and which of its effects are simulated.

    Attributes
    ----------
    turbine : its figures.
    drive : ``"first-order"``: tau beta' = beta_ref - beta; ``"second-order"``:
        beta'' = w^2 (beta_ref - beta) - 2 zeta w beta'.
    tower : the first fore-aft mode; the rotor then sees the wind minus the hub's velocity, which
        is ``turbine.tower_share`` of the tower top's.
    torsion : rotor and generator as two masses; the measured speed is then the generator's.
    wake : the wake needs time; torque and thrust answer pitch, wind and speed more at first.
    pitch_rate_limit [rad/s], torque_rate_limit [N m/s] : inf for none.
    speed_filter : on the measured speed: a ``SpeedFilter``, or the corner of a low-pass alone
        [rad/s]; None for none.
    flap : the first collective flap mode.
    torque_lag : first-order lag of the generator torque [s]; None for none.
    ripple : amplitude of a wind oscillation with three periods per turn, over the wind [-].

    Raises
    ------
    ModelError : an unknown drive, a limit, corner or lag not above 0, a ripple outside 0 to 0.2, or
        flap for a turbine whose file has none.
    """

    turbine: Turbine
    drive: str = "second-order"
    tower: bool = True
    torsion: bool = False
    wake: bool = False
    pitch_rate_limit: float = inf
    torque_rate_limit: float = inf
    speed_filter: SpeedFilter | float | None = None
    flap: bool = False
    torque_lag: float | None = None
    ripple: float = 0.0

    def __post_init__(self) -> None:
        if self.drive not in DRIVES:
            raise ModelError(f"pitch drive {self.drive!r} is not known; choose one of {DRIVES}")
        for name in ("pitch_rate_limit", "torque_rate_limit", "torque_lag"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ModelError(f"{name} = {value:g} was given; it must be above 0")
        SpeedFilter.of(self.speed_filter)
        if not 0 <= self.ripple <= LARGEST_RIPPLE:
            raise ModelError(
                f"ripple = {self.ripple:g} was given; 0 to {LARGEST_RIPPLE:g} of the wind is needed"
            )
        if self.flap and self.turbine.flap is None:
            raise ModelError(
                f"flap was asked for, but the file of {self.turbine.name} has no "
                "blade.flap_frequency, blade.flap_damping, blade.flap_compliance and "
                "blade.flap_velocity_share; add them, or leave the flap mode out"
            )

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states with their units, in order."""
        names = ["rotor speed [rad/s]", "pitch [rad]"]
        if self.drive == "second-order":
            names.append("pitch rate [rad/s]")
        if self.tower:
            names += ["tower-top displacement [m]", "tower-top velocity [m/s]"]
        if self.flap:
            names += ["blade-tip displacement [m]", "blade-tip velocity [m/s]"]
        if self.torsion:
            names += ["generator speed, low-speed side [rad/s]", "shaft twist [rad]"]
        if self.wake:
            names.append("induced wind [m/s]")
        if self.torque_lag is not None:
            names.append("generator torque [N m]")
        if self.ripple:
            names.append("azimuth [rad]")
        filtered = self.filters
        if filtered is not None and filtered.stop:
            names += ["band-stop, first pole [rad/s]", "band-stop, second pole [rad/s]"]
        if filtered is not None:
            names.append("filtered rotor speed [rad/s]")
        return tuple(names)

    @property
    def filters(self) -> SpeedFilter | None:
        """The filter of the measured speed; None for no filter."""
        return SpeedFilter.of(self.speed_filter)

    @property
    def fastest(self) -> float:
        """How fast the fastest part moves [rad/s]; a time step is to be below its inverse."""
        generator = self.turbine.gear_ratio**2 * self.turbine.generator_inertia
        reduced = self.turbine.rotor_inertia * generator / self.turbine.inertia
        shaft = sqrt(self.shaft[0] / reduced) if self.torsion and reduced else 0.0
        return max(shaft, 1 / self.torque_lag if self.torque_lag else 0.0)

    @property
    def shaft(self) -> tuple[float, float]:
        """Stiffness [N m/rad] and damping [N m s/rad] between the two masses, low-speed side.

        Those that give the torsion mode of the file, where it has one: the blades bend in their
        plane too, so that the mode is softer than the shaft.
        """
        turbine, mode = self.turbine, self.turbine.torsion
        if mode is None:
            return turbine.shaft_stiffness, turbine.shaft_damping
        generator = turbine.gear_ratio**2 * turbine.generator_inertia
        reduced = turbine.rotor_inertia * generator / turbine.inertia
        return reduced * mode.frequency**2, 2 * mode.damping * mode.frequency * reduced

    def index(self, name: str) -> int | None:
        """Return the place of the state whose name begins so, or None if it is not modelled."""
        for number, full in enumerate(self.state_names):
            if full.startswith(name):
                return number
        return None

    def initial_state(self, wind: float) -> tuple[Floats, TrimPoint]:
        """Return the resting state at a constant wind [m/s], and the trim it belongs to.

        Below cut-in and above cut-out the rotor starts from the trim at that end.
        """
        turbine = self.turbine
        point = trim(turbine, min(max(wind, turbine.cut_in), turbine.cut_out))
        speed, pitch = point.rotor_speed, point.pitch
        thrust = float(rotor_thrust(turbine, speed, pitch, wind, clip=True))
        twist = float(rotor_torque(turbine, speed, pitch, wind, clip=True))
        start = {
            "rotor speed": speed,
            "pitch [": pitch,
            "tower-top displacement": turbine.tower_share * thrust / turbine.tower_stiffness,
            "blade-tip displacement": turbine.flap.compliance * thrust if turbine.flap else 0.0,
            "generator speed": speed,
            "shaft twist": twist / self.shaft[0],
            "induced wind": steady_induced_wind(turbine, speed, pitch, wind) if self.wake else 0.0,
            "generator torque": point.torque,
            "band-stop, first pole": speed,
            "band-stop, second pole": speed,
            "filtered rotor speed": speed,
        }
        state = np.zeros(len(self.state_names))
        for name, value in start.items():
            number = self.index(name)
            if number is not None:
                state[number] = value
        return state, point


def validation_plant(
    turbine: Turbine,
    *,
    tower: bool = True,
    torsion: bool | None = None,
    wake: bool = True,
    flap: bool | None = None,
    pitch_rate_limit: float | None = None,
    torque_rate_limit: float | None = None,
    torque_lag: float | None = None,
    speed_filter: SpeedFilter | float | None = None,
    ripple: float = 0.0,
) -> SimulatedTurbine:
    """Return the rich plant: wake, flap, tower, torsion, second-order pitch drive, limits, lag.

    Parameters
    ----------
    tower, wake, speed_filter, ripple : see ``SimulatedTurbine``.
    torsion, flap : None takes the mode where the turbine's file states it.
    pitch_rate_limit : [rad/s]; None takes the turbine's (8 deg/s for the NREL 5-MW).
    torque_rate_limit : [N m/s]; None takes the turbine's: 15 kN m/s for the NREL 5-MW, which is
        what its own controller was published with.  Other controllers of it allow 40 kN m/s: a
        law that needs more than the smaller one shall show that it does.
    torque_lag : [s]; None takes the turbine's, none where its file has none; 0 for none.
    """
    if pitch_rate_limit is None:
        pitch_rate_limit = turbine.pitch_rate_limit
    if torque_rate_limit is None:
        torque_rate_limit = turbine.torque_rate_limit
    return SimulatedTurbine(
        turbine,
        "second-order",
        tower=tower,
        torsion=turbine.torsion is not None if torsion is None else torsion,
        wake=wake,
        pitch_rate_limit=pitch_rate_limit,
        torque_rate_limit=torque_rate_limit,
        speed_filter=speed_filter,
        flap=turbine.flap is not None if flap is None else flap,
        torque_lag=turbine.torque_lag if torque_lag is None else torque_lag or None,
        ripple=ripple,
    )


def design_plant(turbine: Turbine) -> SimulatedTurbine:
    """Return the stiff plant of the design: J omega' = T_r - n_g T, tau beta' = beta_ref - beta.

    No tower, no rate limits; pitch and torque stay inside their ranges.
    """
    return SimulatedTurbine(turbine, "first-order", tower=False)


def steady_induced_wind(turbine: Turbine, speed: float, pitch: float, wind: float) -> float:
    """Return w = k_a a(c_T) v [m/s] at rotor speed [rad/s], pitch [rad] and wind [m/s]."""
    from takagi.models.simulation.equations import LEAST_FLOW, induction

    scale = turbine.torque_constant / turbine.rotor_radius * wind**2
    thrust = float(rotor_thrust(turbine, speed, pitch, wind, clip=True))
    share = turbine.wake.induction * induction(thrust / scale)[0]
    return min(share, 1.0 - LEAST_FLOW) * wind
