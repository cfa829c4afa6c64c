"""The plants that a law is run on: the rich one for validation, the stiff one of the design.

Both are values; what they do in time is in ``takagi.models.simulation.dynamics``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag
from math import inf

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.turbine.aerodynamics import rotor_thrust, rotor_torque
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TrimPoint, trim

DRIVES = ("first-order", "second-order")


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
    """A turbine with what is modelled of it.

    Attributes
    ----------
    turbine : its figures.
    drive : ``"first-order"``: tau beta' = beta_ref - beta; ``"second-order"``:
        beta'' = w^2 (beta_ref - beta) - 2 zeta w beta'.
    tower : the first fore-aft mode m x'' + c x' + k x = F; the rotor then feels v - x'.
    torsion : rotor and generator as two masses with shaft stiffness and damping; the measured
        speed is then the generator's.
    wake : pitch meets a wake that needs time, see ``takagi.models.simulation.wake``.
    pitch_rate_limit [rad/s], torque_rate_limit [N m/s] : inf for none.
    speed_filter : corner of a one-pole filter on the measured speed [rad/s]; None for none.

    Raises
    ------
    ModelError : an unknown drive, or a limit or corner not above 0.
    """

    turbine: Turbine
    drive: str = "second-order"
    tower: bool = True
    torsion: bool = False
    wake: bool = False
    pitch_rate_limit: float = inf
    torque_rate_limit: float = inf
    speed_filter: float | None = None

    def __post_init__(self) -> None:
        if self.drive not in DRIVES:
            raise ModelError(f"pitch drive {self.drive!r} is not known; choose one of {DRIVES}")
        for name in ("pitch_rate_limit", "torque_rate_limit", "speed_filter"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ModelError(f"{name} = {value:g} was given; it must be above 0")

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states with their units, in order."""
        names = ["rotor speed [rad/s]", "pitch [rad]"]
        if self.drive == "second-order":
            names.append("pitch rate [rad/s]")
        if self.tower:
            names += ["tower-top displacement [m]", "tower-top velocity [m/s]"]
        if self.torsion:
            names += ["generator speed, low-speed side [rad/s]", "shaft twist [rad]"]
        if self.wake:
            names.append("wake pitch [rad]")
        if self.speed_filter is not None:
            names.append("filtered rotor speed [rad/s]")
        return tuple(names)

    def index(self, name: str) -> int | None:
        """Return the place of the state whose name begins so, or None if it is not modelled."""
        for place, full in enumerate(self.state_names):
            if full.startswith(name):
                return place
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
            "tower-top displacement": thrust / turbine.tower_stiffness,
            "generator speed": speed,
            "shaft twist": twist / turbine.shaft_stiffness,
            "wake pitch": pitch,
            "filtered rotor speed": speed,
        }
        state = np.zeros(len(self.state_names))
        for name, value in start.items():
            place = self.index(name)
            if place is not None:
                state[place] = value
        return state, point


def validation_plant(
    turbine: Turbine,
    *,
    tower: bool = True,
    torsion: bool = False,
    wake: bool = False,
    pitch_rate_limit: float | None = None,
    torque_rate_limit: float | None = None,
    speed_filter: float | None = None,
) -> SimulatedTurbine:
    """Return the rich plant: second-order pitch drive with limits, torque rate limit, tower.

    Parameters
    ----------
    tower, torsion, wake, speed_filter : see ``SimulatedTurbine``.
    pitch_rate_limit : [rad/s]; None takes the turbine's (8 deg/s for the NREL 5-MW).
    torque_rate_limit : [N m/s]; None takes the turbine's: 15 kN m/s for the NREL 5-MW, which is
        what its own controller was published with.  Other controllers of it allow 40 kN m/s: a
        law that needs more than the smaller one shall show that it does.
    """
    if pitch_rate_limit is None:
        pitch_rate_limit = turbine.pitch_rate_limit
    if torque_rate_limit is None:
        torque_rate_limit = turbine.torque_rate_limit
    return SimulatedTurbine(
        turbine,
        "second-order",
        tower,
        torsion,
        wake,
        pitch_rate_limit,
        torque_rate_limit,
        speed_filter,
    )


def design_plant(turbine: Turbine) -> SimulatedTurbine:
    """Return the stiff plant of the design: J omega' = T_r - n_g T, tau beta' = beta_ref - beta.

    No tower, no rate limits; pitch and torque stay inside their ranges.
    """
    return SimulatedTurbine(turbine, "first-order", tower=False)


# Names that earlier versions had.
Plant = SimulatedTurbine
