"""Margins of the loop that runs: validation plant, observer and law, linearised at a steady wind.

The plant's own right-hand side and the continuous-time law and observer are differenced centrally;
sampling and computation are a delay of both commands (Pade).  The observer reads the torque that
the law asks for, so it belongs to the controller and a break lies behind it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law, Measurement
from takagi.models.simulation.dynamics import equilibrium_state, plant_rate
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.margins.turbine_dynamics import PADE_ORDER
from takagi.reports.margins.turbine_loops import Loops, break_loops

if TYPE_CHECKING:
    from control import StateSpace

# Of a value's own size (at least its floor); a slope may change by this share at half the step.
STEP, AGREEMENT = 1e-5, 1e-3


def slopes(function: Callable[[Floats], Floats], at: Floats, steps: Floats) -> Floats:
    """Return the Jacobian by central differences, checked against half the step.

    Raises
    ------
    ModelError : the two differ by more than a share of the column's largest slope.
    """

    def columns(size: float) -> Floats:
        moved = [size * step * unit for step, unit in zip(steps, np.eye(len(at)), strict=True)]
        pairs = [(function(at + move) - function(at - move)) / 2 for move in moved]
        return np.array([p / (size * s) for p, s in zip(pairs, steps, strict=True)]).T

    whole, half = columns(1.0), columns(0.5)
    scale = np.maximum(np.abs(half).max(axis=0, keepdims=True), 1e-12)
    worst = float((np.abs(whole - half) / scale).max())
    if worst > AGREEMENT:
        raise ModelError(f"slopes at half the step differ by {worst:.2g}; a limit or kink is near")
    return half


def running_plant(plant: SimulatedTurbine, wind: float, delay: float) -> StateSpace:
    """Return (torque, pitch reference) -> (measured speed, pitch) with the delay of both."""
    import control

    state, torque, pitch = equilibrium_state(plant, wind)
    rate, n = plant_rate(plant), len(state)
    at = np.concatenate([state, [torque, pitch]])
    steps = STEP * np.maximum(np.abs(at), 1e-1)
    J = slopes(lambda x: rate(x[:n], float(x[n]), float(x[n + 1]), wind), at, steps)
    places = (plant.index(name) for name in ("filtered", "generator speed", "rotor speed"))
    C = np.eye(n)[[next(place for place in places if place is not None), 1]]
    late = control.ss(control.tf(*control.pade(delay, PADE_ORDER)))
    return control.ss(J[:, :n], J[:, n:], C, 0.0) * control.append(late, late)


def running_controller(law: Law, observer: WindObserver, plant: SimulatedTurbine, wind: float) -> StateSpace:
    """Return (measured speed, pitch) -> (torque, pitch reference) of observer and law."""
    import control

    state, _, pitch = equilibrium_state(plant, wind)
    speed, inner = float(state[0]), law.initial_state(wind)
    at = np.concatenate([inner, observer.initial_state(speed, wind), [speed, pitch]])
    k, n = len(inner), len(inner) + 2

    def answer(x: Floats) -> Floats:
        seen = Measurement(float(x[n]), float(x[n + 1]), observer.wind_estimate(x[k:n]))
        command = law.command(x[:k], seen)
        estimated = observer.state_rate(x[k:n], seen.rotor_speed, seen.pitch, command.torque)
        return np.concatenate([law.state_rate(x[:k], seen), estimated, command])

    J = slopes(answer, at, STEP * np.maximum(np.abs(at), 1e-1))
    return control.ss(J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:])


def running_loops(plant: SimulatedTurbine, law: Law, observer: WindObserver, wind: float, *, delay: float) -> Loops:
    """Return the loops of the machine at a steady wind [m/s]; delay: T / 2 + computation [s]."""
    return break_loops(
        running_plant(plant, wind, delay), running_controller(law, observer, plant, wind)
    )
