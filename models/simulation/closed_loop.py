"""A law that is a Python object on a plant in a wind: fixed-step Runge-Kutta, sampled and held.

Laws of gain files run by ``compiled_loop``, which is some times faster and computes the same; this
loop takes any other law.

At every controller sample the law sees (speed, pitch, wind estimate) and what it sends holds until
the next one, as in a digital controller (``takagi.models.laws.protocol``); with a computation time
it takes effect that much later.  Torque follows its command within the plant's rate limit, from
sample to sample; pitch goes through the drive.  The observer takes one Euler step per sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from math import ceil, inf, isfinite
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Command, Law, Measurement, SampledLaw
from takagi.models.simulation.turbine_plant import Flag, SimulatedTurbine, advance, loads
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine, rotor_thrust
from takagi.models.turbine.trim import rated_wind, trim


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class History:
    """A closed loop over time, one row per controller sample; all arrays are (n,) and read-only.

    Attributes
    ----------
    time [s]; wind, wind_estimate [m/s] : the wind without the tower's motion, and what the law saw.
    rotor_speed [rad/s]; generator_speed : as seen from the low-speed side [rad/s], equal to
        rotor_speed without torsion.
    pitch, pitch_reference [rad]; pitch_rate [rad/s].
    torque : of the generator, high-speed shaft, in force from this sample to the next [N m].
    torque_command : what the law asked for [N m].
    electrical_power : efficiency times torque times generator speed [W].
    rotor_torque [N m], thrust [N] : aerodynamic, at the sample.
    shaft_torque : in the low-speed shaft: that of its twist, without torsion what the generator
        and its inertia take from the rotor [N m].
    tower_displacement [m], tower_velocity [m/s] : fore-aft, at the top; 0 without a tower.
    tower_moment : fore-aft at the base [N m]: hub height times (stiffness x + damping x') over the
        turbine's ``tower_share``, which is thrust times hub height at rest.
    blade_moment : flapwise at the root of each blade, of the mode that all blades share [N m]: the
        blade's elastic load, in place of which stands the thrust without a flap mode, as a load
        that grows with the radius, so that it acts at two thirds of it.
    plant_states : (n, m), in the order of the plant's ``state_names``.
    law_states : (n, k), in the order of the law's ``state_names``.
    flags : (n,) integers, sums of ``takagi.models.simulation.turbine_plant.Flag``.
    """

    time: Floats
    wind: Floats
    wind_estimate: Floats
    rotor_speed: Floats
    generator_speed: Floats
    pitch: Floats
    pitch_reference: Floats
    pitch_rate: Floats
    torque: Floats
    torque_command: Floats
    electrical_power: Floats
    rotor_torque: Floats
    thrust: Floats
    shaft_torque: Floats
    tower_displacement: Floats
    tower_velocity: Floats
    tower_moment: Floats
    blade_moment: Floats
    plant_states: Floats
    law_states: Floats
    flags: NDArray[np.int64]

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def share_flagged(self, flag: Flag) -> float:
        """Return the share of samples at which the flag stands [-]."""
        return float(np.mean((self.flags & flag.value) != 0))

    def first_flagged(self, flag: Flag) -> float:
        """Return when the flag first stands [s]; inf if it never does."""
        standing = (self.flags & flag.value) != 0
        return float(self.time[np.argmax(standing)]) if standing.any() else inf

    def per_unit(self, turbine: Turbine) -> dict[str, Floats]:
        """Return the series over their bases [-], by name; ``time`` stays in s.

        Bases: wind and its estimate by rated wind; rotor speed, torque and electrical power by
        their rated values; pitch and its reference by the trim pitch at cut-out; tower
        displacement and moment by their static values at rated wind.
        """
        wind = rated_wind(turbine)
        thrust = float(rotor_thrust(turbine, turbine.rated_rotor_speed, turbine.pitch_min, wind))
        bases = {
            "wind": wind,
            "wind_estimate": wind,
            "rotor_speed": turbine.rated_rotor_speed,
            "pitch": trim(turbine, turbine.cut_out).pitch,
            "pitch_reference": trim(turbine, turbine.cut_out).pitch,
            "torque": turbine.rated_torque,
            "electrical_power": turbine.rated_power,
            "tower_displacement": turbine.tower_share * thrust / turbine.tower_stiffness,
            "tower_moment": thrust * turbine.hub_height,
        }
        scaled = {name: np.asarray(getattr(self, name)) / base for name, base in bases.items()}
        return {"time": self.time, **scaled}


# Of the plant's integration [s]: resolves all its modes.
TIME_STEP = 0.02
# A computation time is looked for among the steps of up to this many more to a sample.
MOST_STEPS = 400


def fitting_step(sample_time: float, computation_time: float, longest: float = TIME_STEP) -> float:
    """Return the largest step up to ``longest`` [s] that divides sample and computation time."""
    period, late = sample_time, computation_time
    # A period that is a whole multiple of the longest step must not get one more step by rounding.
    fewest_steps = max(1, ceil(period / longest - 1e-9))
    for count in range(fewest_steps, fewest_steps + MOST_STEPS):
        share = late * count / period
        if abs(share - round(share)) < 1e-9 * count:
            return period / count
    raise ModelError(
        f"computation time {late:g} s was given with a sample time of {period:g} s; a simple "
        "fraction of the sample time is needed, such as a half or a quarter"
    )


def plant_step(plant: SimulatedTurbine, sample_time: float, computation_time: float) -> float:
    """Return the plant's time step [s], the largest that resolves its modes and fits the times."""
    # The fastest mode limits the step: a fixed-step method is unstable with much longer ones.
    longest = min(TIME_STEP, 1 / max(plant.fastest, 1e-9))
    return fitting_step(sample_time, computation_time, longest)


def step_counts(time_step: float, period: float, wind: WindSeries) -> tuple[int, int]:
    """Return (time steps per controller sample, controller samples)."""
    if not time_step > 0:
        raise ModelError(f"time step {time_step:g} s was given; it must be above 0")
    inner = whole_steps(period, time_step, "sample time")
    # The quotient of two decimals such as 0.3 / 0.1 may be just below a whole number.
    samples = int(wind.duration / period + 1e-9)
    if samples < 1:
        raise ModelError(
            f"wind {wind.name!r} lasts {wind.duration:g} s, less than one step of {period:g} s"
        )
    return inner, samples


def whole_steps(time: float, step: float, time_name: str) -> int:
    """Return how many steps a time is."""
    count = round(time / step)
    if abs(count * step - time) > 1e-9 * time:
        raise ModelError(
            f"{time_name} {time:g} s was given with time step {step:g} s; it must be a whole "
            "multiple of it"
        )
    return count


class Observer(Protocol):
    """What estimates the wind from speed [rad/s], pitch [rad] and torque (high-speed) [N m]."""

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        """Return the state for a measured speed and a first guess of the wind [m/s]."""
        ...

    def wind_estimate(self, state: Floats) -> float:
        """Return the estimate [m/s]."""
        ...

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        """Return the time derivative of the state."""
        ...


class Diverged(ModelError):
    """The states of a loop grew beyond all numbers; ``time`` [s] says when."""

    def __init__(self, law: str, wind: str, time: float) -> None:
        super().__init__(
            f"law {law!r} in {wind!r}: the loop grew beyond all numbers before {time:.6g} s; make "
            "the steps smaller or the gains lower"
        )
        self.law, self.wind, self.time = law, wind, time

    def __reduce__(self) -> tuple[type[Diverged], tuple[str, str, float]]:
        # Pickled by its parts, so that it comes back whole from another process.
        return Diverged, (self.law, self.wind, self.time)


class _Sample(NamedTuple):
    state: Floats
    wind: float
    wind_estimate: float
    command: Command
    torque: float
    law_state: Floats

    @property
    def row(self) -> tuple[Floats | float, ...]:
        """The sample in the order of ``Record``."""
        torque, pitch = (float(value) for value in self.command)
        seen = float(self.wind_estimate)
        return self.state, self.wind, seen, torque, pitch, self.torque, self.law_state


def simulate(
    plant: SimulatedTurbine,
    law: Law | SampledLaw,
    wind: WindSeries,
    *,
    observer: Observer | None = None,
    time_step: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> History:
    """Return the closed loop over the whole wind series, from rest at its first wind.

    Parameters
    ----------
    law : a ``SampledLaw`` with its sample time, computation time and rate limits; another law
        runs at every time step, or every 0.02 s.
    observer : gives the wind estimate; None lets the law see the true wind.
    time_step : of the plant's fourth-order Runge-Kutta integration [s]; None takes the largest one
        up to 0.02 that resolves the plant's modes and fits the sampling.
    progress : called with the share done, in (0, 1], about a hundred times.

    Raises
    ------
    ModelError : steps that do not fit.
    Diverged : a ModelError; the states grow beyond all numbers, the message says when.
    """
    program = law if isinstance(law, SampledLaw) else SampledLaw(law, time_step or TIME_STEP)
    if time_step is None:
        time_step = plant_step(plant, program.sample_time, program.computation_time)
    inner, samples = step_counts(time_step, program.sample_time, wind)
    record: list[_Sample] = []
    for sample in _march(plant, program, wind, observer, time_step, inner, samples):
        record.append(sample)
        if progress is not None and len(record) % max(1, samples // 100) == 0:
            progress(min(len(record) / samples, 1.0))
    columns = zip(*(sample.row for sample in record), strict=True)
    rows = Record(*(np.array(column, dtype=np.float64) for column in columns))
    _, point = plant.initial_state(float(wind.speed[0]))
    return history_of(plant, wind, rows, program.sample_time, point.torque)


def _march(
    plant: SimulatedTurbine,
    program: SampledLaw,
    wind: WindSeries,
    observer: Observer | None,
    time_step: float,
    inner: int,
    samples: int,
) -> Iterator[_Sample]:
    """Yield one sample per controller step, the last one at the end of the wind."""
    period = time_step * inner
    late = whole_steps(program.computation_time, time_step, "computation time")
    start, point = plant.initial_state(float(wind.speed[0]))
    state = start
    previous = Command(point.torque, point.pitch)
    within = program.start(float(wind.speed[0]), previous)
    estimator = np.zeros(0)
    if observer is not None:
        estimator = observer.initial_state(point.rotor_speed, float(wind.speed[0]))
    speed_at = measured_speed(plant)
    # The wind at half steps, for the middle of a Runge-Kutta step.
    winds = wind.at(wind.time[0] + np.arange(2 * inner * samples + 1) * (time_step / 2))
    for first in range(0, 2 * inner * samples + 1, 2 * inner):
        if not isfinite(sum(state.tolist()) + sum(within.law_state.tolist())):
            raise Diverged(program.name, wind.name, first / 2 * time_step)
        v = float(winds[first])
        wind_seen = v if observer is None else observer.wind_estimate(estimator)
        measurement = Measurement(float(state[speed_at]), float(state[1]), wind_seen)
        law_state = within.law_state
        command, within = program.step(within, measurement)
        torque = limit_torque(plant, previous.torque, float(command.torque), period)
        sent_command = Command(torque, float(command.pitch))
        yield _Sample(state, v, wind_seen, command, torque, law_state)
        if observer is not None:
            torques = previous.torque, torque
            estimator = observed(observer, estimator, measurement, torques, late / inner, period)
        sent, ahead = np.array([*previous, *sent_command]), winds[first : first + 2 * inner + 1]
        state = advance(plant, state, sent, late, ahead, time_step)
        previous = sent_command


def observed(
    observer: Observer,
    state: Floats,
    seen: Measurement,
    torques: tuple[float, float],
    late: float,
    period: float,
) -> Floats:
    """Return the observer's state a period [s] later, by one Euler step.

    It reads the mean of the torques [N m] before and from this sample on; the former acts for the
    share ``late`` of the period.
    """
    before, torque = torques
    mean = torque + late * (before - torque)
    return state + period * observer.state_rate(state, seen.rotor_speed, seen.pitch, mean)


def measured_speed(plant: SimulatedTurbine) -> int:
    """Return which state is the measured speed: filtered, the generator's, or the rotor's."""
    indices = (plant.index(name) for name in ("filtered", "generator speed", "rotor speed"))
    return next(index for index in indices if index is not None)


def limit_torque(
    plant: SimulatedTurbine, previous: float, commanded: float, period: float
) -> float:
    """Return the torque within its range and what the rate limit allows since."""
    largest_step = plant.torque_rate_limit * period
    torque = min(max(commanded, 0.0), plant.turbine.maximum_torque)
    if abs(torque - previous) > largest_step:
        torque = previous + (largest_step if torque > previous else -largest_step)
    return torque


class Record(NamedTuple):
    """What a loop leaves, a row a sample: states, wind and its estimate, commands, torque sent."""

    states: Floats
    wind: Floats
    wind_estimate: Floats
    torque_command: Floats
    pitch_reference: Floats
    torque: Floats
    law_states: Floats


def history_of(
    plant: SimulatedTurbine, wind: WindSeries, record: Record, period: float, first_torque: float
) -> History:
    """Return the series of a record that was sampled every ``period`` [s].

    ``first_torque`` : in force before the first sample [N m].
    """
    turbine, states = plant.turbine, record.states
    speed, pitch = states[:, 0], states[:, 1]
    turning, thrust, flags = loads(plant, states, record.pitch_reference, record.wind)
    generator_at, tower_at = plant.index("generator speed"), plant.index("tower")
    tip_at, flap = plant.index("blade-tip"), turbine.flap
    elastic = thrust if tip_at is None or flap is None else states[:, tip_at] / flap.compliance
    generator = speed if generator_at is None else states[:, generator_at]
    zeros = np.zeros(len(states))
    top = zeros if tower_at is None else states[:, tower_at]
    top_speed = zeros if tower_at is None else states[:, tower_at + 1]
    power = turbine.generator_efficiency * turbine.gear_ratio * record.torque * generator
    return History(
        time=wind.time[0] + period * np.arange(len(states)),
        wind=record.wind,
        wind_estimate=record.wind_estimate,
        rotor_speed=speed.copy(),
        generator_speed=generator.copy(),
        pitch=pitch.copy(),
        pitch_reference=record.pitch_reference,
        pitch_rate=_pitch_rate(plant, states, record.pitch_reference),
        torque=record.torque,
        torque_command=record.torque_command,
        electrical_power=power,
        rotor_torque=turning,
        thrust=thrust,
        shaft_torque=_shaft_torque(plant, record, turning),
        tower_displacement=top.copy(),
        tower_velocity=top_speed.copy(),
        tower_moment=turbine.hub_height
        / turbine.tower_share
        * (turbine.tower_stiffness * top + turbine.tower_damping * top_speed),
        blade_moment=2 / 9 * turbine.rotor_radius * elastic,
        plant_states=states,
        law_states=record.law_states,
        flags=flags | _torque_flags(plant, record, period, first_torque),
    )


def _shaft_torque(plant: SimulatedTurbine, record: Record, turning: Floats) -> Floats:
    """Return the torque in the low-speed shaft [N m], (n,)."""
    turbine, states = plant.turbine, record.states
    at, lagged = plant.index("generator speed"), plant.index("generator torque")
    if at is not None:
        stiffness, damping = plant.shaft
        return stiffness * states[:, at + 1] + damping * (states[:, 0] - states[:, at])
    acting = record.torque if lagged is None else states[:, lagged]
    surplus = turning - turbine.gear_ratio * acting
    return turning - turbine.rotor_inertia / turbine.inertia * surplus


def _torque_flags(
    plant: SimulatedTurbine, record: Record, period: float, first_torque: float
) -> NDArray[np.int64]:
    """Return the flags of the torque's range and rate, a row a sample."""
    inside = np.clip(record.torque_command, 0.0, plant.turbine.maximum_torque)
    before = np.concatenate([[first_torque], record.torque[:-1]])
    limited = inside != record.torque_command
    slowed = np.abs(inside - before) > plant.torque_rate_limit * period
    flags = np.where(limited, Flag.TORQUE_LIMITED.value, 0)
    flags += np.where(slowed, Flag.TORQUE_RATE_LIMITED.value, 0)
    return flags


def _pitch_rate(plant: SimulatedTurbine, states: Floats, references: Floats) -> Floats:
    if plant.drive == "second-order":
        return np.asarray(states[:, 2].copy(), dtype=np.float64)
    turbine, limit = plant.turbine, plant.pitch_rate_limit
    limited = np.clip(references, turbine.pitch_min, turbine.pitch_max)
    rate = (limited - states[:, 1]) / turbine.pitch_time_constant
    return np.asarray(np.clip(rate, -limit, limit), dtype=np.float64)
