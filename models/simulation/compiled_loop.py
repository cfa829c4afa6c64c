"""A law that is a program on a plant in a wind, compiled; it runs without the interpreter's lock.

Sampling, holding, limits and observer are those of ``closed_loop``, and so are the results.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law, require_times
from takagi.models.simulation.closed_loop import (
    Diverged,
    History,
    Observer,
    Record,
    history_of,
    measured_speed,
    plant_step,
    step_counts,
    whole_steps,
)
from takagi.models.simulation.turbine_plant import SimulatedTurbine, constants
from takagi.models.simulation.wind import WindSeries

if TYPE_CHECKING:
    from takagi.models.simulation.equations import Instructions


@dataclass(frozen=True, slots=True, eq=False)
class CompiledLaw:
    """A law, its observer, and the program of both.

    Attributes
    ----------
    law : where its states rest;  observer : where its states start, None where it has none.
    program : keeps the observer's states, then the law's.
    """

    law: Law
    observer: Observer | None
    program: Instructions

    @property
    def name(self) -> str:
        """The law's word for tables."""
        return self.law.name

    def start(self, rotor_speed: float, wind: float) -> Floats:
        """Return what is kept before the first sample, at rest at this speed and wind."""
        estimate = np.zeros(0)
        if self.observer is not None:
            estimate = self.observer.initial_state(rotor_speed, wind)
        kept = np.concatenate([estimate, self.law.initial_state(wind)])
        if len(kept) < len(self.program.kept):
            raise ModelError(
                f"law {self.name!r}: its program keeps {len(self.program.kept)} values and it has "
                f"{len(kept)} states; they must be the same"
            )
        # A law without its wind filter keeps the filter's state in Python alone.
        return kept[: len(self.program.kept)]


def simulate_compiled(
    plant: SimulatedTurbine,
    law: CompiledLaw,
    wind: WindSeries,
    *,
    sample_time: float,
    computation_time: float = 0.0,
) -> History:
    """Return the closed loop over the whole wind series, from rest at its first wind.

    ``sample_time``, ``computation_time`` : of the law's program [s].

    Raises
    ------
    ModelError : times that do not fit.
    Diverged : a ModelError; the states grow beyond all numbers, the message says when.
    """
    from takagi.models.simulation import equations

    require_times(sample_time, computation_time)
    step = plant_step(plant, sample_time, computation_time)
    inner, samples = step_counts(step, sample_time, wind)
    late = whole_steps(computation_time, step, "computation time")
    state, point = plant.initial_state(float(wind.speed[0]))
    winds = wind.at(wind.time[0] + np.arange(2 * inner * samples + 1) * (step / 2))
    kept = law.start(point.rotor_speed, float(wind.speed[0]))
    states, keeps = np.empty((samples + 1, len(state))), np.empty((samples + 1, len(kept)))
    signals = np.empty((samples + 1, 4))
    end = equations.march(
        constants(plant),
        law.program,
        state,
        kept,
        np.array([point.torque, point.pitch], dtype=np.float64),
        winds,
        (inner, late, step),
        measured_speed(plant),
        (plant.turbine.maximum_torque, plant.torque_rate_limit),
        states,
        keeps,
        signals,
    )
    if end >= 0:
        raise Diverged(law.name, wind.name, end * sample_time)
    own = 0 if law.observer is None else len(law.observer.initial_state(point.rotor_speed, 1.0))
    estimate, torque_command, reference, torque = (column.copy() for column in signals.T)
    record = Record(
        states,
        winds[:: 2 * inner].copy(),
        estimate,
        torque_command,
        reference,
        torque,
        keeps[:, own:].copy(),
    )
    return history_of(plant, wind, record, sample_time, point.torque)
