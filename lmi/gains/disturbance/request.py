"""The request for a design against disturbances, checked on entry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import number
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.gains.disturbance.coordinates import DisturbanceCoordinates
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    Performance,
    check_reachable,
    plant_of,
)
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DisturbanceRequest:
    """A plant, and the other requirements on its gains.

    Attributes
    ----------
    decay_rate : alpha in 1/s that is asked for.
    limits : in the model's units; None where there are none.
    given : the same, as they were given.
    tolerance : how far above its least value the objective may end, relative.
    peak, energy : of the disturbance, to be 1 where the limits are posed; None where free.
    noise : the disturbance is white.
    growth : as for ``DisturbanceCoordinates.of``.
    guess : of P, but for its size; None takes that of a regulator.
    feedback : a guess of the gains beside that of P; None takes a regulator's.
    """

    plant: DisturbedPlant
    relaxation: str
    decay_rate: float
    limits: Limits | None
    tolerance: float
    given: GivenLimits
    peak: float | None = None
    energy: float | None = None
    noise: bool = False
    growth: float = 1.0
    guess: Floats | None = None
    feedback: Floats | None = None

    @property
    def level(self) -> bool:
        """Return whether limits fix the size of the ellipsoid x' P x <= 1."""
        return self.limits is not None and self.limits.level

    def inside(self, units: DisturbanceCoordinates) -> Limits | None:
        """Return the limits in the given coordinates."""
        return None if self.limits is None else self.limits.scaled(units.scales, units.inputs)

    def plain(self) -> Design:
        """Return gains without regard to the disturbance, by ``pdc``."""
        reaching, limits = self.plant.reaching, self.given
        return pdc(
            reaching,
            decay_rate=self.decay_rate,
            relaxation=self.relaxation,
            # Merged inputs are not those that the limit is about.
            input_limit=limits.input_limit if reaching is self.plant else None,
            initial_box=limits.initial_box,
            initial_ball=limits.initial_ball,
            state_box=limits.state_box,
            gain_bound=limits.gain_bound,
        )

    def mean_of(self, plain: Design) -> Floats | None:
        """Return the mean (m, n) of plain gains; None where they are those of merged inputs."""
        if plain.gains is None or plain.gains.shape[1] != self.plant.B.shape[2]:
            return None
        return np.asarray(plain.gains.mean(axis=0))


def disturbance_request(
    model: Disturbed,
    limits_given: GivenLimits,
    *,
    performance: Performance | None,
    relaxation: str,
    decay_rate: float,
    tolerance: float,
) -> DisturbanceRequest:
    """Return the checked task.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, no disturbance, no output, inputs that are
        dependent or do nothing, a vertex with an unstable mode that no input moves, a tolerance
        below 1e-7, which no solver keeps.
    """
    relaxation_named(relaxation)
    plant = plant_of(model, performance, limits_given.sample_time)
    limits = limits_given.limits(*plant.B.shape[1:])
    check_reachable(plant, getattr(model, "states", ()))
    return DisturbanceRequest(
        plant=plant,
        relaxation=relaxation,
        decay_rate=float(number("decay_rate", decay_rate, at_least=0.0)),
        limits=limits if limits.level or limits.gain is not None else None,
        tolerance=float(number("tolerance", tolerance, at_least=1e-7)),
        given=limits_given,
    )


def positive_number(name: str, value: float) -> float:
    """Return a positive number.

    Raises
    ------
    ModelError : it is not one.
    """
    number_read = float(number(name, value))
    if number_read <= 0:
        raise ModelError(f"{name} is {number_read:g}; it must be positive")
    return number_read
