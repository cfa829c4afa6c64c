"""The objective of the one-step design: a weight for each quantity that shall become better."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from takagi.models.errors import ModelError, did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Objective:
    """Weights of an objective: the sum of weight times logarithm of each quantity is minimised.

    A quantity that shall grow enters with a minus sign.  Logarithms make the weights independent
    of units: equal weights trade one per cent of one quantity for one per cent of another.

    Attributes
    ----------
    wind_class : weight of the largest multiple of the wind class for which {x' P x <= 1} is
        invariant and inside the box.
    overspeed : weight of the peak of the speed error under the wind class that was requested.
    decay : weight of the common decay rate at constant wind.
    kept : every step keeps at least this share of the wind error that the starting gains tolerate,
        on the mean over wind and in the weakest cell.
    """

    wind_class: float = 1.0
    overspeed: float = 0.0
    decay: float = 0.0
    kept: float = 1.0

    def __post_init__(self) -> None:
        weights = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in weights.items():
            if not 0 <= value < 1e3:
                raise ModelError(f"{name} = {value!r} was given; a number from 0 to 1000 is needed")
        if not 0 < self.kept <= 1:
            raise ModelError(f"kept = {self.kept!r} was given; a share above 0, up to 1, is needed")
        if not sum(value for name, value in weights.items() if name != "kept") > 0:
            raise ModelError("all weights are 0; give at least one objective a weight above 0")


# Named sets of weights.  In our runs ``balanced`` reached the same wind class as ``wind-class`` and
# took half as much time again, because the decay rate adds inequalities of its own.
OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        "balanced": Objective(decay=0.1),
        "wind-class": Objective(),
        "decay": Objective(wind_class=0.1, decay=1.0),
    }
)


def objective_named(name: str) -> Objective:
    """Return the weights that belong to a name.

    Raises
    ------
    ModelError : the name is unknown; the message lists the known names.
    """
    if name not in OBJECTIVES:
        raise ModelError(
            f"objective {name!r} was given{did_you_mean(name, OBJECTIVES)}; choose one of "
            f"{', '.join(OBJECTIVES)}"
        )
    return OBJECTIVES[name]
