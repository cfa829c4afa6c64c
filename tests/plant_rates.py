"""The right side of a plant itself, for tests that compare with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.plant import Plant
from takagi.models.plant_simulation.runs import right_side


def plant_rate(
    plant: Plant, uncertain: Mapping[str, Fraction] | None = None
) -> Callable[[Floats, Floats], Floats]:
    """Return (x, u) -> x'; ``uncertain`` : signal -> value of what else acts, otherwise at rest."""
    rate, none = right_side(plant, fixed=uncertain), np.zeros(0)
    return lambda x, u: rate(x, u, none)
