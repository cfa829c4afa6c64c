"""Where the loop that runs is at rest in a steady wind, and the slopes of a function there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law, Measurement, law_words
from takagi.models.simulation.closed_loop import Observer
from takagi.models.simulation.dynamics import equilibrium_state, plant_rate
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.models.turbine.aerodynamics import rotor_torque_gradient

# Largest accepted rate of a state at rest, as a share of the state's size per second.
AT_REST = 1e-9
# Lengths of implicit steps [s]: Newton's, and what is tried where these lead nowhere.
NEWTON = np.full(20, np.inf)
PATIENT = np.concatenate([np.full(40, 3.0), np.geomspace(3.0, 1e9, 30), np.full(10, np.inf)])


class NoEquilibrium(ModelError):
    """The loop has no rest at a wind: there is nothing to linearise at."""


@dataclass(frozen=True, slots=True, eq=False)
class LoopEquilibrium:
    """The states of plant, law and observer at rest, and the commands (torque, pitch) there."""

    plant: Floats
    law: Floats
    observer: Floats
    commands: Floats


def loop_equilibrium(
    plant: SimulatedTurbine, law: Law, observer: Observer, wind: float
) -> LoopEquilibrium:
    """Return where the loop rests: near the turbine's trim, where the law and its tables say.

    It depends on neither inertia nor sampling nor the wake's time.

    Raises
    ------
    NoEquilibrium : a ModelError; none is found from the trim.
    ModelError : a wind outside cut-in to cut-out, or a rest at which more wind gives no more
        torque: there the observer cannot estimate it.
    """
    start, torque, pitch = equilibrium_state(plant, wind)
    at, n, k = measured_speed(plant), len(start), len(law.state_names)
    rate, low, high = plant_rate(plant), plant.turbine.pitch_min, plant.turbine.pitch_max
    estimate = observer.initial_state(float(start[at]), wind)
    state = np.concatenate([start, law.initial_state(wind), estimate])

    def commands(s: Floats) -> tuple[Measurement, Floats]:
        seen = Measurement(float(s[at]), float(s[1]), observer.wind_estimate(s[n + k :]))
        return seen, np.array(law.command(s[n : n + k], seen), dtype=np.float64)

    def moving(s: Floats) -> Floats:
        seen, sent = commands(s)
        estimated = observer.state_rate(s[n + k :], seen.rotor_speed, seen.pitch, float(sent[0]))
        moved = rate(s[:n], float(sent[0]), float(sent[1]), wind)
        return np.concatenate([moved, law.state_rate(s[n : n + k], seen), estimated])

    size = np.maximum(np.abs(state), 0.1)
    for times in (NEWTON, PATIENT):
        found = _at_rest(moving, state, size, times, (low, high))
        if found is not None:
            _require_seen(plant, found, wind)
            return LoopEquilibrium(found[:n], found[n : n + k], found[n + k :], commands(found)[1])
    raise NoEquilibrium(
        f"at {wind:g} m/s the loop of the {law_words(law.name)} has no rest near the turbine's "
        f"trim (torque {torque:.6g} N m, pitch {pitch:.6g} rad): leave this wind out"
    )


def _at_rest(
    moving: Callable[[Floats], Floats],
    state: Floats,
    size: Floats,
    times: Floats,
    pitch: tuple[float, float],
) -> Floats | None:
    """Return where nothing moves, or None: one implicit Euler step for each time [s].

    Long steps are Newton's; short ones follow the motion of the loop, past kinks too.
    """
    for time in times:
        left = moving(state)
        if float((np.abs(left) / size).max()) < AT_REST:
            return state
        bends = slopes(moving, state, np.ones(len(state))).matrix
        system = (np.eye(len(state)) / time - bends) * size
        state = state + np.linalg.lstsq(system / size[:, None], left / size, rcond=1e-12)[0] * size
        state[1] = min(max(state[1], pitch[0]), pitch[1])
        for stop in pitch:
            if abs(state[1] - stop) < AT_REST:
                state[1] = stop
    return None


def measured_speed(plant: SimulatedTurbine) -> int:
    """Return which state is the measured speed: filtered, the generator's, or the rotor's."""
    places = (plant.index(name) for name in ("filtered", "generator speed", "rotor speed"))
    return next(place for place in places if place is not None)


def _require_seen(plant: SimulatedTurbine, state: Floats, wind: float) -> None:
    speed, pitch = float(state[0]), float(state[1])
    slope = float(rotor_torque_gradient(plant.turbine, speed, pitch, wind)[2])
    if slope <= 0:
        raise ModelError(
            f"at {wind:g} m/s more wind gives no more torque (dT/dv = {slope:.3g} N m s/m at "
            f"{speed:.4g} rad/s): the rotor stalls and the observer cannot see the wind; raise the "
            "speed set-point, or leave this wind out"
        )


# Of a value's own size, at least of FLOOR: the step of a difference.
STEP, FLOOR = 1e-5, 1e-1
# At a kink the jump of the slopes stays while the step is halved; a bend's jump halves.
STAYS, VISIBLE = 0.75, 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """A Jacobian, and at which coordinates the function has a kink.

    Attributes
    ----------
    matrix : (m, n).
    kinks : coordinates whose two one-sided slopes differ; ``matrix`` has the asked side's there.
    """

    matrix: Floats
    kinks: tuple[int, ...]


def slopes(function: Callable[[Floats], Floats], at: Floats, sides: Floats) -> Slopes:
    """Return the slopes of a function at a point.

    Parameters
    ----------
    sides : (n,) +1 or -1, the side on which a kink is read; elsewhere differences are central.
    """
    steps = STEP * np.maximum(np.abs(at), FLOOR)
    here = function(at)

    def one_sided(size: float) -> Floats:
        """Slopes to the second order in the step, (m, n)."""
        found = []
        for unit, step in zip(np.eye(len(at)), steps, strict=True):
            near, far = (function(at + share * size * step * unit) for share in (0.5, 1.0))
            found.append((4 * near - 3 * here - far) / (size * step))
        return np.array(found).T

    # A jump of the second-order slopes is a kink's alone, up to terms of the step squared.
    up, down = one_sided(1.0), one_sided(-1.0)
    jump, still = np.abs(up - down), np.abs(one_sided(0.5) - one_sided(-0.5))
    size = np.maximum(np.abs(up), np.abs(down)) * steps
    seen = jump * steps > VISIBLE * size.max(axis=1, keepdims=True)
    kinked = np.flatnonzero((seen & (still > STAYS * jump)).any(axis=0))
    matrix = (up + down) / 2
    matrix[:, kinked] = np.where(sides[kinked] > 0, up[:, kinked], down[:, kinked])
    return Slopes(matrix, tuple(int(k) for k in kinked))
