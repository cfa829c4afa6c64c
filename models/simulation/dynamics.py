"""A plant as functions on Python floats, built once per plant: the inner loop of a simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.simulation.turbine_plant import Flag, SimulatedTurbine
from takagi.models.simulation.wake import excess_sensitivity, wake_time_constant
from takagi.models.splines.scalar_surface import scalar_surface
from takagi.models.turbine.data import Turbine

State = list[float]
# A wind below this is no wind for a rotor; the tip-speed ratio is clipped long before [m/s].
SMALLEST_WIND = 0.1


class Loads(NamedTuple):
    """Rotor torque [N m], thrust [N] and what of the table or drive is at its end."""

    rotor_torque: float
    thrust: float
    flags: int


class Dynamics(NamedTuple):
    """The plant's right-hand side and its outputs; states are lists in the order of its names.

    derivative(state, torque, pitch_reference, wind) -> state rate
    hold(state) : moves pitch and its rate back inside their limits, in place
    loads(state, pitch_reference, wind) -> Loads
    """

    derivative: Callable[[State, float, float, float], State]
    hold: Callable[[State], None]
    loads: Callable[[State, float, float], Loads]


Rotor = Callable[[float, float, float], tuple[float, float]]
Drive = Callable[[State, float, State], None]
Wake = Callable[[State, float, float, State], float]


@lru_cache(maxsize=32)
def dynamics(plant: SimulatedTurbine) -> Dynamics:
    """Return the functions of a plant."""
    turbine = plant.turbine
    rotor, drive, wake = _rotor(turbine), _drive(plant), _wake(plant)
    top, twist_at, lag = (plant.index(n) for n in ("tower", "generator", "filtered"))
    mass, damping, stiffness = turbine.tower_mass, turbine.tower_damping, turbine.tower_stiffness
    n_g, corner = turbine.gear_ratio, plant.speed_filter or 0.0
    shaft_k, shaft_c = turbine.shaft_stiffness, turbine.shaft_damping
    rotor_inertia = turbine.rotor_inertia if plant.torsion else turbine.inertia
    generator_inertia = turbine.gear_ratio**2 * turbine.generator_inertia
    size = len(plant.state_names)

    def derivative(state: State, torque: float, reference: float, wind: float) -> State:
        rate = [0.0] * size
        v = wind if top is None else wind - state[top + 1]
        turning, thrust = rotor(state[0], state[1], v)
        drive(state, reference, rate)
        if wake is not None:
            turning += wake(state, v, thrust, rate)
        if top is not None:
            speed = state[top + 1]
            rate[top] = speed
            rate[top + 1] = (thrust - damping * speed - stiffness * state[top]) / mass
        measured = state[0]
        load = n_g * torque
        if twist_at is not None:
            measured = state[twist_at]
            slip = state[0] - measured
            shaft = shaft_k * state[twist_at + 1] + shaft_c * slip
            rate[twist_at] = (shaft - load) / generator_inertia
            rate[twist_at + 1] = slip
            load = shaft
        rate[0] = (turning - load) / rotor_inertia
        if lag is not None:
            rate[lag] = corner * (measured - state[lag])
        return rate

    return Dynamics(derivative, _hold(plant), _loads(plant, rotor, wake))


def plant_derivative(
    plant: SimulatedTurbine,
    state: Sequence[float],
    torque: float,
    pitch_reference: float,
    wind: float,
) -> Floats:
    """Return the time derivative of the plant's state, same order as ``state_names``.

    Parameters
    ----------
    torque : of the generator, on the high-speed shaft [N m].
    pitch_reference [rad], wind [m/s] (undisturbed by the tower's own motion).
    """
    rate = dynamics(plant).derivative(list(state), torque, pitch_reference, wind)
    return np.array(rate, dtype=np.float64)


def _rotor(turbine: Turbine) -> Rotor:
    """Return (T_r, F) of speed, pitch and wind, coefficients held at the table's edge."""
    c_q, c_t = scalar_surface(turbine.torque), scalar_surface(turbine.thrust)
    radius, k = turbine.rotor_radius, turbine.torque_constant
    k_thrust = k / radius

    def rotor(speed: float, pitch: float, wind: float) -> tuple[float, float]:
        v = wind if wind > SMALLEST_WIND else SMALLEST_WIND
        ratio = speed * radius / v
        square = v * v
        return k * square * c_q(ratio, pitch), k_thrust * square * c_t(ratio, pitch)

    return rotor


def _drive(plant: SimulatedTurbine) -> Drive:
    """Return what writes the pitch drive's rates: reference and rate held inside their limits."""
    turbine = plant.turbine
    low, high, limit = turbine.pitch_min, turbine.pitch_max, plant.pitch_rate_limit
    frequency = turbine.pitch_drive_frequency
    spring, friction = frequency**2, 2 * turbine.pitch_drive_damping * frequency
    lag = turbine.pitch_time_constant

    def first_order(state: State, reference: float, rate: State) -> None:
        target = low if reference < low else high if reference > high else reference
        wanted = (target - state[1]) / lag
        rate[1] = -limit if wanted < -limit else limit if wanted > limit else wanted

    def second_order(state: State, reference: float, rate: State) -> None:
        target = low if reference < low else high if reference > high else reference
        speed = state[2]
        acceleration = spring * (target - state[1]) - friction * speed
        if (speed >= limit and acceleration > 0) or (speed <= -limit and acceleration < 0):
            acceleration = 0.0
        rate[1] = -limit if speed < -limit else limit if speed > limit else speed
        rate[2] = acceleration

    return first_order if plant.drive == "first-order" else second_order


def _wake(plant: SimulatedTurbine) -> Wake | None:
    """Return what adds g(v) (beta - beta_w) to rotor torque and writes beta_w', or None."""
    place = plant.index("wake")
    if place is None:
        return None
    excess, radius = excess_sensitivity(plant.turbine), plant.turbine.rotor_radius
    k_thrust = plant.turbine.torque_constant / radius

    def wake(state: State, wind: float, thrust: float, rate: State) -> float:
        v = wind if wind > SMALLEST_WIND else SMALLEST_WIND
        gap = state[1] - state[place]
        rate[place] = gap / wake_time_constant(thrust / (k_thrust * v * v), radius, v)
        return excess(v) * gap

    return wake


def _hold(plant: SimulatedTurbine) -> Callable[[State], None]:
    low, high, limit = plant.turbine.pitch_min, plant.turbine.pitch_max, plant.pitch_rate_limit
    has_rate = plant.drive == "second-order"

    def hold(state: State) -> None:
        if has_rate:
            state[2] = min(max(state[2], -limit), limit)
        if not low <= state[1] <= high:
            state[1] = min(max(state[1], low), high)
            if has_rate:
                # A blade that meets its stop stands; it may only leave inwards.
                inwards = 1.0 if state[1] == low else -1.0
                state[2] = inwards * max(inwards * state[2], 0.0)

    return hold


def _loads(
    plant: SimulatedTurbine, rotor: Rotor, wake: Wake | None
) -> Callable[[State, float, float], Loads]:
    turbine = plant.turbine
    top, limit = plant.index("tower"), plant.pitch_rate_limit
    drive, size = _drive(plant), len(plant.state_names)
    ratio_range, pitch_range = turbine.torque.x_range, turbine.torque.y_range

    def loads(state: State, reference: float, wind: float) -> Loads:
        v = wind if top is None else wind - state[top + 1]
        turning, thrust = rotor(state[0], state[1], v)
        rate = [0.0] * size
        drive(state, reference, rate)
        if wake is not None:
            turning += wake(state, v, thrust, rate)
        ratio = state[0] * turbine.rotor_radius / max(v, SMALLEST_WIND)
        flags = 0
        if not ratio_range[0] <= ratio <= ratio_range[1]:
            flags |= Flag.TIP_SPEED_RATIO_CLIPPED.value
        if not pitch_range[0] <= state[1] <= pitch_range[1]:
            flags |= Flag.PITCH_OUTSIDE_TABLE.value
        if abs(rate[1]) >= limit:
            flags |= Flag.PITCH_RATE_LIMITED.value
        if not turbine.pitch_min <= reference <= turbine.pitch_max:
            flags |= Flag.PITCH_POSITION_LIMITED.value
        return Loads(turning, thrust, flags)

    return loads
