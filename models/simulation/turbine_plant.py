"""The turbine that is simulated, and the filter of its measured speed.

What is done to the measured speed before observer and law read it.

    a' = w (y - a)        b' = w (a - b)        z = y - 2 (1 - p) (a - b)        m' = c (z - m)

y is the measured speed, m what is read.  The first part is the band-stop

    z / y = (s^2 + 2 p w s + w^2) / (s + w)^2,

which passes the share p at its frequency w, everything far from it, and turns the phase forward
above it.  It keeps a mode of the drivetrain out of the loop.  The second part is a low-pass.

The plants that a law is run on: the rich one for validation, the stiff one of the design.

Both are values.  What they do in time are functions, built once per plant; its equations are in
``equations``.

Numba is imported with the first plant that is built, and its equations are compiled with
their first call: some ten seconds once, after that they are read from the disk.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntFlag
from functools import lru_cache
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.splines.spline import patch_coefficients
from takagi.models.turbine.data import FlapMode, Turbine, rotor_thrust, rotor_torque
from takagi.models.turbine.trim import TrimPoint, trim

if TYPE_CHECKING:
    from takagi.models.simulation.equations import Constants


# What a band-stop lets through at its frequency. Less makes its phase turn faster around it, so
# that a mode that is softer than the file says loses its margin (docs/laws.md).
PASSED = 0.2


@dataclass(frozen=True, slots=True)
class SpeedFilter:
    """A low-pass of one pole on the measured speed, and a band-stop before it.

    Attributes
    ----------
    corner : c, of the low-pass [rad/s].
    stop : w, frequency of the band-stop [rad/s]; 0 for none.
    passed : p, the share of that frequency that passes the band-stop [-].

    Raises
    ------
    ModelError : a corner not above 0, a frequency below 0, a share outside 0 to 1.
    """

    corner: float
    stop: float = 0.0
    passed: float = PASSED

    def __post_init__(self) -> None:
        if not (isfinite(self.corner) and self.corner > 0):
            raise ModelError(
                f"speed_filter = {self.corner:g} rad/s was given; it must be above 0"
                + (", for a band-stop needs a low-pass behind it" if self.stop else "")
            )
        if not (isfinite(self.stop) and self.stop >= 0):
            raise ModelError(
                f"torsion_filter = {self.stop:g} rad/s was given; a frequency above 0 is needed, "
                "or 0 for none"
            )
        if not 0 <= self.passed <= 1:
            raise ModelError(
                f"the share that passes the band-stop was given as {self.passed:g}; 0 to 1 "
                "is needed"
            )

    @classmethod
    def of(cls, value: SpeedFilter | float | None) -> SpeedFilter | None:
        """Return a filter as it is, a number as the corner of a low-pass alone; None for none."""
        return value if value is None or isinstance(value, SpeedFilter) else cls(value)


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
        return max(self.torsion_frequency, 1 / self.torque_lag if self.torque_lag else 0.0)

    @property
    def torsion_frequency(self) -> float:
        """Of the free torsion mode [rad/s]; 0 without one."""
        reduced = self._reduced_inertia
        return sqrt(self.shaft[0] / reduced) if self.torsion and reduced else 0.0

    @property
    def shaft(self) -> tuple[float, float]:
        """Stiffness [N m/rad] and damping [N m s/rad] between the two masses, low-speed side.

        Those that give the torsion mode of the file, where it has one: the blades bend in their
        plane too, so that the mode is softer than the shaft.
        """
        turbine, mode, reduced = self.turbine, self.turbine.torsion, self._reduced_inertia
        if mode is None:
            return turbine.shaft_stiffness, turbine.shaft_damping
        return reduced * mode.frequency**2, 2 * mode.damping * mode.frequency * reduced

    @property
    def _reduced_inertia(self) -> float:
        turbine = self.turbine
        generator = turbine.gear_ratio**2 * turbine.generator_inertia
        return turbine.rotor_inertia * generator / turbine.inertia

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
    torque_lag: float | None = None,
    speed_filter: SpeedFilter | float | None = None,
    ripple: float = 0.0,
) -> SimulatedTurbine:
    """Return the rich plant: wake, flap, tower, torsion, second-order pitch drive, limits, lag.

    The limits of the rates are the turbine's: 8 deg/s and 15 kN m/s for the NREL 5-MW, which is
    what its own controller was published with.  Other controllers of it allow 40 kN m/s: a law
    that needs more than the smaller one shall show that it does.

    Parameters
    ----------
    tower, wake, speed_filter, ripple : see ``SimulatedTurbine``.
    torsion, flap : None takes the mode where the turbine's file states it.
    torque_lag : [s]; None takes the turbine's, none where its file has none; 0 for none.
    """
    return SimulatedTurbine(
        turbine,
        tower=tower,
        torsion=turbine.torsion is not None if torsion is None else torsion,
        wake=wake,
        pitch_rate_limit=turbine.pitch_rate_limit,
        torque_rate_limit=turbine.torque_rate_limit,
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


def loads(
    plant: SimulatedTurbine, states: Floats, references: Floats, winds: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return rotor torque [N m], thrust [N] and ``Flag`` of the table and the drive, a row a state.

    ``states`` : (n, m).   references : pitch references [rad], (n,).   winds : [m/s], (n,).
    """
    from takagi.models.simulation import equations

    turbine = plant.turbine
    turning, thrust, ratio, turned = equations.record(constants(plant), states, references, winds)
    (low, high), (lowest_pitch, highest_pitch) = turbine.torque.x_range, turbine.torque.y_range
    pitch = states[:, 1]
    flags = np.zeros(len(states), dtype=np.int64)
    for flag, stands in (
        (Flag.TIP_SPEED_RATIO_CLIPPED, (ratio < low) | (ratio > high)),
        (Flag.PITCH_OUTSIDE_TABLE, (pitch < lowest_pitch) | (pitch > highest_pitch)),
        (Flag.PITCH_RATE_LIMITED, np.abs(turned) >= plant.pitch_rate_limit),
        (
            Flag.PITCH_POSITION_LIMITED,
            (references < turbine.pitch_min) | (references > turbine.pitch_max),
        ),
    ):
        flags |= np.where(stands, flag.value, 0)
    return turning, thrust, flags


@lru_cache(maxsize=32)
def plant_rate(plant: SimulatedTurbine) -> Callable[[Floats, float, float, float], Floats]:
    """Return f(state, torque, pitch_reference, wind) -> state rate; names: ``plant.state_names``.

    What is sent to the generator is ``torque`` [N m, high-speed shaft], to the drive
    ``pitch_reference`` [rad]; ``wind`` is undisturbed by the machine [m/s].  The function is smooth
    wherever no limit acts and no table ends, so that central differences linearise it; the wake's
    inner equation is solved to 1e-13.
    """
    from takagi.models.simulation import equations

    known = constants(plant)

    def derivative(state: Floats, torque: float, reference: float, wind: float) -> Floats:
        rates = np.empty(len(state))
        values = np.ascontiguousarray(state, dtype=np.float64)
        equations.rate(known, values, torque, reference, wind, rates)
        return rates

    return derivative


def advance(
    plant: SimulatedTurbine, state: Floats, sent: Floats, late: int, winds: Floats, step: float
) -> Floats:
    """Return the state after the time steps of one sample, see ``equations.advance``."""
    from takagi.models.simulation import equations

    return equations.advance(constants(plant), state, sent, late, winds, step)


# Figures that the equations know by the turbine's own names.
OF_TURBINE = (
    *("rotor_radius", "torque_constant", "rotor_inertia", "gear_ratio"),
    *("tower_mass", "tower_damping", "tower_stiffness", "tower_share"),
    *("pitch_time_constant", "pitch_drive_frequency", "pitch_drive_damping"),
    *("pitch_min", "pitch_max"),
)
STATE_NAMES = {
    "pitch_rate": "pitch rate",
    "tower": "tower",
    "flap": "blade-tip",
    "generator": "generator speed",
    "wake": "induced wind",
    "torque": "generator torque",
    "azimuth": "azimuth",
    "stopped": "band-stop",
    "filtered": "filtered",
}


@lru_cache(maxsize=32)
def constants(plant: SimulatedTurbine) -> Constants:
    """Return what the equations know of a plant."""
    from takagi.models.simulation.equations import Constants

    turbine = plant.turbine
    flap = turbine.flap or FlapMode(0.0, 0.0, 0.0, 0.0)
    places = {name: plant.index(begin) for name, begin in STATE_NAMES.items()}
    given: dict[str, Any] = {name: -1 if k is None else k for name, k in places.items()}
    given |= {name: getattr(turbine, name) for name in OF_TURBINE}
    stiffness, damping = plant.shaft
    filters = plant.filters
    tables: dict[str, Any] = {}
    for name in ("torque", "thrust"):
        x, y, patches = patch_coefficients(getattr(turbine, name))
        tables |= {f"{name}_x": x, f"{name}_y": y, f"{name}_patches": patches}
    return Constants(
        **given,
        generator_inertia=turbine.gear_ratio**2 * turbine.generator_inertia,
        shaft_stiffness=stiffness,
        shaft_damping=damping,
        flap_frequency=flap.frequency,
        flap_damping=flap.damping,
        flap_compliance=flap.compliance,
        flap_share=flap.velocity_share,
        disc_induction=turbine.wake.induction,
        wake_share=turbine.wake.time_share,
        torque_lag=plant.torque_lag or inf,
        pitch_rate_limit=plant.pitch_rate_limit,
        ripple=plant.ripple,
        filter_corner=filters.corner if filters else 0.0,
        stop_frequency=filters.stop if filters else 0.0,
        stop_passed=filters.passed if filters else 1.0,
        **tables,
    )
