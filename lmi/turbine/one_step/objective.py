"""What the one-step design makes better: weights on relative changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from takagi.models.errors import ModelError, did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Objective:
    """Weights of relative improvements; the sum of weight times logarithm is minimised.

    Attributes
    ----------
    wind_class : on the largest multiple of the wind class that the set inside the box tolerates.
    overspeed : on the peak of the speed error under the wind class as it is asked for.
    decay : on the common decay rate at constant wind.
    pitch : on the standard deviation of the pitch rate in turbulence.
    tower : on that of the tower's speed; both are estimates about the trim, no bounds
        (``motion``).
    kept : share of what the start tolerates, on the mean over wind and in its weakest cell, that no
        step may fall below.
    """

    wind_class: float = 1.0
    overspeed: float = 0.0
    decay: float = 0.0
    pitch: float = 0.0
    tower: float = 0.0
    kept: float = 1.0

    def __post_init__(self) -> None:
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in given.items():
            if not 0 <= value < 1e3:
                raise ModelError(f"{name} = {value!r} was given; a number from 0 to 1000 is needed")
        if not 0 < self.kept <= 1:
            raise ModelError(f"kept = {self.kept!r} was given; a share above 0, up to 1, is needed")
        if not sum(value for name, value in given.items() if name != "kept") > 0:
            raise ModelError("all weights are 0; give at least one objective a weight above 0")

    @property
    def watches_motion(self) -> bool:
        """Whether pitch or tower count."""
        return self.pitch > 0 or self.tower > 0


# Weights that have a name.  The balance costs no wind class that was measured, and half as much
# time again: decay has inequalities of its own.
OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        "balanced": Objective(decay=0.1),
        "wind-class": Objective(),
        "decay": Objective(wind_class=0.1, decay=1.0),
        "calm-pitch": Objective(wind_class=0.1, pitch=1.0, kept=0.85),
        "calm-tower": Objective(wind_class=0.1, tower=1.0, kept=0.85),
    }
)


def objective_named(name: str) -> Objective:
    """Return the weights of a name.

    Raises
    ------
    ModelError : no such name; says which there are.
    """
    if name not in OBJECTIVES:
        raise ModelError(
            f"objective {name!r} was given{did_you_mean(name, OBJECTIVES)}; choose one of "
            f"{', '.join(OBJECTIVES)}"
        )
    return OBJECTIVES[name]
