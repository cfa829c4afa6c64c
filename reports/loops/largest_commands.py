"""The largest commands on the ellipsoid, in floating point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop


def largest_commands(loop: PlantLoop) -> list[tuple[str, float]]:
    """Return (input, largest |u - u*| of any rule on the ellipsoid): sqrt(c K_i P^-1 K_i').

    In floating point; empty where there is no bounded ellipsoid.
    """
    if loop.gains is None or not loop.bounded:
        return []
    if loop.observed is not None:
        most = loop.observed.largest_commands()
        assert most is not None  # the set is bounded
        return [(name, float(size)) for name, size in zip(loop.model.inputs, most, strict=True)]
    P, level = loop.ellipsoid
    inverse = np.linalg.inv(P)
    size = np.sqrt(level * np.einsum("imn,nk,imk->im", loop.gains, inverse, loop.gains))
    return [(name, float(most)) for name, most in zip(loop.model.inputs, size.max(0), strict=True)]
