"""Slopes of a function by differences, with its kinks named and read on one side.

A function that stands at a clip, or at a node of a table that is linear between nodes, has two
slopes there; a central difference would give their mean, which is the slope of neither side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats

# Of a value's own size, at least of FLOOR: the step of a difference.
STEP, FLOOR = 1e-5, 1e-1
# At a kink the jump of the slopes stays while the step is halved; a bend's jump halves.
STAYS, VISIBLE = 0.75, 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """A Jacobian, and at which coordinates the function has a kink.

    Attributes
    ----------
    matrix : (m, n).
    kinks : coordinates whose two one-sided slopes differ; ``matrix`` has the asked side's there.
    """

    matrix: Floats
    kinks: tuple[int, ...]


def slopes(function: Callable[[Floats], Floats], at: Floats, sides: Floats) -> Slopes:
    """Return the slopes of a function at a point.

    Parameters
    ----------
    sides : (n,) +1 or -1, the side on which a kink is read; elsewhere differences are central.
    """
    steps = STEP * np.maximum(np.abs(at), FLOOR)
    here = function(at)

    def one_sided(size: float) -> Floats:
        """Slopes to the second order in the step, (m, n)."""
        found = []
        for unit, step in zip(np.eye(len(at)), steps, strict=True):
            near, far = (function(at + share * size * step * unit) for share in (0.5, 1.0))
            found.append((4 * near - 3 * here - far) / (size * step))
        return np.array(found).T

    # A jump of the second-order slopes is a kink's alone, up to terms of the step squared.
    up, down = one_sided(1.0), one_sided(-1.0)
    jump, still = np.abs(up - down), np.abs(one_sided(0.5) - one_sided(-0.5))
    size = np.maximum(np.abs(up), np.abs(down)) * steps
    seen = jump * steps > VISIBLE * size.max(axis=1, keepdims=True)
    kinked = np.flatnonzero((seen & (still > STAYS * jump)).any(axis=0))
    matrix = (up + down) / 2
    matrix[:, kinked] = np.where(sides[kinked] > 0, up[:, kinked], down[:, kinked])
    return Slopes(matrix, tuple(int(k) for k in kinked))
