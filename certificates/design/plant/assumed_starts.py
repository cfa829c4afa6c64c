"""Starts for a design that needs some, where none were given.

A damping, a fastest pole, a bound on gains, or the largest decay rate with limited inputs: each
means something only together with the states from which the limits are to be kept.  The starts
taken are a share of the largest box, in the proportions of the states' ranges, from which any
gains keep all limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.ts.model import TSModel

# Tried in this order, until there are gains.
SHARES = (0.5, 0.25, 0.125)


def needs_starts(asked: PlantSettings) -> bool:
    """Return whether limited inputs need starts for what is asked, and none were given."""
    wishes = (asked.damping, asked.fastest, asked.gain_bound)
    return not asked.initial and (
        asked.decay_rate == "max" or any(wish is not None for wish in wishes)
    )


def largest_set(model: TSModel, box: Floats, input_limit: Floats) -> Design:
    """Return the design whose set holds the largest multiple of the box.

    Raises
    ------
    ModelError : a state has no range, and so nothing says in which proportion it may start.
    """
    from takagi.lmi import attraction_pdc

    missing = [name for name, half in zip(model.states, box, strict=True) if np.isinf(half)]
    if missing:
        first = missing[0].partition(" [")[0]
        raise ModelError(
            f"state {first} has neither a range nor a start, and with limited inputs damping, "
            f'fastest, gain_bound and decay_rate = "max" need one; give {first} a range, or '
            f"initial = {{ {first} = half-width }}"
        )
    return attraction_pdc(
        model, input_limit=input_limit, state_box=box, saturation=None, measure=box
    )


def largest_multiple(design: Design, box: Floats) -> float:
    """Return a number whose multiple of the box is inside {x' P x <= 1}, the largest within it."""
    from takagi.lmi.gains.requirements.limits import corners_of_box

    corners = corners_of_box(box)
    values = np.einsum("ki,ij,kj->k", corners, np.asarray(design.require()[1]), corners)
    return float(1 / np.sqrt(values.max()))
