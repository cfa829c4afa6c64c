"""A simulated turbine as a system of python-control: rotor, drive, and what else it has."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.simulation.dynamics import dynamics
from takagi.models.simulation.turbine_plant import SimulatedTurbine

if TYPE_CHECKING:
    import control

INPUTS = ["torque", "pitch_reference", "wind"]
# Step of the differences, as a share of the state's or input's size.
STEP = 1e-5


def turbine_system(plant: SimulatedTurbine) -> control.NonlinearIOSystem:
    """Return the turbine's equations; inputs torque [N m], pitch_reference [rad], wind [m/s].

    Outputs are the states.  The drive holds its reference and its rate within their limits.
    """
    import control

    run = dynamics(plant)
    names = signal_names(plant.state_names)

    def update(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        torque, reference, wind = map(float, u)
        return run.derivative(np.asarray(x, dtype=np.float64), torque, reference, wind)

    return control.nlsys(
        update, None, name="turbine", states=names, inputs=INPUTS, outputs=names, dt=0
    )


def turbine_statespace(plant: SimulatedTurbine, wind: float) -> control.StateSpace:
    """Return the linear system at the trim of a wind [m/s], by differences of second order.

    Pitch and its reference are moved upwards alone: below rated wind they lie at the end of their
    range, where the drive holds them.

    Raises
    ------
    ModelError : a wind that is not within cut-in and cut-out.
    """
    import control

    turbine = plant.turbine
    if not turbine.cut_in <= wind <= turbine.cut_out:
        raise ModelError(
            f"at: wind = {wind!r} was given; {turbine.cut_in:g} to {turbine.cut_out:g} m/s is "
            "needed"
        )
    run = dynamics(plant)
    state, point = plant.initial_state(wind)
    names = signal_names(plant.state_names)
    n = len(names)
    centre = np.array([*state, point.torque, point.pitch, wind])

    def rate(place: Floats) -> Floats:
        torque, reference, v = map(float, place[n:])
        return run.derivative(place[:n], torque, reference, v)

    J = np.zeros((n, n + 3))
    for k, name in enumerate([*names, *INPUTS]):
        step = np.zeros(n + 3)
        step[k] = STEP * max(1.0, abs(centre[k]))
        if "pitch" in name:
            two, one = rate(centre + 2 * step), rate(centre + step)
            J[:, k] = (4 * one - two - 3 * rate(centre)) / (2 * step[k])
        else:
            J[:, k] = (rate(centre + step) - rate(centre - step)) / (2 * step[k])
    return control.ss(
        J[:, :n], J[:, n:], np.eye(n), np.zeros((n, 3)), states=names, inputs=INPUTS, outputs=names
    )


def signal_names(labels: Iterable[str]) -> list[str]:
    """Return labels such as ``rotor speed [rad/s]`` as ``rotor_speed``.

    python-control has a meaning for a dot in a name, and none for units.
    """
    return [re.sub(r"\W+", "_", label.split(" [")[0]).strip("_") for label in labels]
