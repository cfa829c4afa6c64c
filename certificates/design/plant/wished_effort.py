"""The words small, moderate and large effort, in numbers.

small      inputs may use half of their ranges; a rate is taken only if it leaves four fifths of the
           largest set; without limits of inputs gains of half the norm are tried at the same rate
moderate   inputs may use their ranges, a rate may cost two fifths of the set (or double commands)
large      a rate may cost seven tenths of the set (or make commands four times as large); without
           limits of inputs rates four times as high are tried

A limit that is given by name, ``input_limit``, is kept as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import Effort


@dataclass(frozen=True, slots=True)
class Price:
    """What a wish allows.

    Attributes
    ----------
    room : share of an input's range that commands may use.
    starts_kept : share of the largest set's starts that a faster loop must leave.
    commands : how many times as large a doubled rate may make the commands.
    """

    room: float
    starts_kept: float
    commands: float


PRICES: dict[Effort, Price] = {
    "small": Price(room=0.5, starts_kept=0.8, commands=1.5),
    "moderate": Price(room=1.0, starts_kept=0.6, commands=2.0),
    "large": Price(room=1.0, starts_kept=0.3, commands=4.0),
}
# Shares of the largest gain's norm that a small effort tries, least first.
SMALLER = (0.5, 0.7, 0.85)


def gain_size(design: Design) -> float:
    """Return the largest spectral norm of a gain, in the units of the model."""
    gains = np.asarray(design.require()[0])
    return float(np.linalg.norm(gains, 2, axis=(1, 2)).max())
