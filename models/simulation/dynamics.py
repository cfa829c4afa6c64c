"""A plant as functions, built once per plant; its equations are in ``equations``.

Numba is imported with the first plant that is built here, and its equations are compiled with
their first call: some ten seconds once, after that they are read from the disk.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.simulation.turbine_plant import Flag, SimulatedTurbine
from takagi.models.splines.scalar_surface import patch_coefficients
from takagi.models.turbine.data import FlapMode

if TYPE_CHECKING:
    from takagi.models.simulation.equations import Constants


class Dynamics(NamedTuple):
    """The plant's right-hand side and its outputs; states are vectors in the order of its names.

    derivative(state, torque, pitch_reference, wind) -> state rate
    hold(state) : moves pitch and its rate back inside their limits, in place
    advance(state, sent, late, winds, step) -> state after the time steps of one sample, see
        ``takagi.models.simulation.equations.advance``
    """

    derivative: Callable[[Floats, float, float, float], Floats]
    hold: Callable[[Floats], None]
    advance: Callable[[Floats, Floats, int, Floats, float], Floats]


def loads(
    plant: SimulatedTurbine, states: Floats, references: Floats, winds: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return rotor torque [N m], thrust [N] and ``Flag`` of the table and the drive, a row a state.

    Parameters
    ----------
    states : (n, m).   references : pitch references [rad], (n,).   winds : [m/s], (n,).
    """
    from takagi.models.simulation import equations

    turbine, constants = plant.turbine, _constants(plant)
    turning, thrust, ratio, turned = equations.record(constants, states, references, winds)
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
def dynamics(plant: SimulatedTurbine) -> Dynamics:
    """Return the functions of a plant."""
    from takagi.models.simulation import equations

    constants = _constants(plant)

    def derivative(state: Floats, torque: float, reference: float, wind: float) -> Floats:
        rates = np.empty(len(state))
        values = np.ascontiguousarray(state, dtype=np.float64)
        equations.rate(constants, values, torque, reference, wind, rates)
        return rates

    return Dynamics(
        derivative,
        lambda state: equations.hold(constants, state),
        lambda state, sent, late, winds, step: equations.advance(
            constants, state, sent, late, winds, step
        ),
    )


def ready(plant: SimulatedTurbine) -> None:
    """Compile what a simulation of the plant calls, or read it from the disk, before it runs."""
    state, point = plant.initial_state(plant.turbine.cut_in)
    sent = np.array([point.torque, point.pitch] * 2)
    dynamics(plant).advance(state, sent, 0, np.full(1, point.wind), 1.0)
    loads(plant, state[None], np.array([point.pitch]), np.array([point.wind]))


def plant_rate(plant: SimulatedTurbine) -> Callable[[Floats, float, float, float], Floats]:
    """Return f(state, torque, pitch_reference, wind) -> state rate; names: ``plant.state_names``.

    What is sent to the generator is ``torque`` [N m, high-speed shaft], to the drive
    ``pitch_reference`` [rad]; ``wind`` is undisturbed by the machine [m/s].  The function is smooth
    wherever no limit acts and no table ends, so that central differences linearise it; the wake's
    inner equation is solved to 1e-13.
    """
    return dynamics(plant).derivative


def equilibrium_state(plant: SimulatedTurbine, wind: float) -> tuple[Floats, float, float]:
    """Return (state, torque [N m], pitch reference [rad]) at rest in a constant wind [m/s].

    Raises
    ------
    ModelError : a wind outside cut-in to cut-out.
    """
    from takagi.models.turbine.trim import trim

    trim(plant.turbine, wind)
    state, point = plant.initial_state(wind)
    return state, point.torque, point.pitch


@lru_cache(maxsize=32)
def _constants(plant: SimulatedTurbine) -> Constants:
    """Return what the equations know of a plant."""
    from takagi.models.simulation.equations import Constants

    turbine = plant.turbine
    flap = turbine.flap or FlapMode(0.0, 0.0, 0.0, 0.0)
    state_names = {
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
    indices: dict[str, Any] = {
        name: -1 if (index := plant.index(begin)) is None else index
        for name, begin in state_names.items()
    }
    stiffness, damping = plant.shaft
    filters = plant.filters
    tables: dict[str, Any] = {}
    for name in ("torque", "thrust"):
        x, y, patches = patch_coefficients(getattr(turbine, name))
        tables |= {f"{name}_x": x, f"{name}_y": y, f"{name}_patches": patches}
    return Constants(
        **indices,
        radius=turbine.rotor_radius,
        torque_constant=turbine.torque_constant,
        rotor_inertia=turbine.rotor_inertia,
        generator_inertia=turbine.gear_ratio**2 * turbine.generator_inertia,
        gear_ratio=turbine.gear_ratio,
        shaft_stiffness=stiffness,
        shaft_damping=damping,
        tower_mass=turbine.tower_mass,
        tower_damping=turbine.tower_damping,
        tower_stiffness=turbine.tower_stiffness,
        tower_share=turbine.tower_share,
        flap_frequency=flap.frequency,
        flap_damping=flap.damping,
        flap_compliance=flap.compliance,
        flap_share=flap.velocity_share,
        disc_induction=turbine.wake.induction,
        wake_share=turbine.wake.time_share,
        torque_lag=plant.torque_lag or inf,
        pitch_lag=turbine.pitch_time_constant,
        drive_frequency=turbine.pitch_drive_frequency,
        drive_damping=turbine.pitch_drive_damping,
        pitch_min=turbine.pitch_min,
        pitch_max=turbine.pitch_max,
        pitch_rate_limit=plant.pitch_rate_limit,
        ripple=plant.ripple,
        filter_corner=filters.corner if filters else 0.0,
        stop_frequency=filters.stop if filters else 0.0,
        stop_passed=filters.passed if filters else 1.0,
        **tables,
    )
