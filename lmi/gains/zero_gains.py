"""A warning where a design's gains do nothing, because the plant meets the request by itself."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import numpy as np

from takagi.lmi.answer import Design
from takagi.lmi.cone.balance import motion, state_units
from takagi.models.arrays import Floats

P = ParamSpec("P")

# Gains are zero where they move the states by less than this share of what the plant does itself.
NUMERICALLY_ZERO = 1e-4


class ZeroGainsWarning(UserWarning):
    """The gains are numerically zero: the plant alone meets what was asked for."""


def warns_of_zero_gains(design_of: Callable[P, Design]) -> Callable[P, Design]:
    """Return the design function with the warning, which calls by takagi itself do not get."""

    @wraps(design_of)
    def warned(*args: P.args, **kwargs: P.kwargs) -> Design:
        design = design_of(*args, **kwargs)
        caller = str(sys._getframe(1).f_globals.get("__name__"))
        gains = None if caller.startswith("takagi.") else design.gains
        if gains is not None and _are_zero(args[0] if args else kwargs["model"], gains):
            warnings.warn(
                "the gains are numerically zero: the plant alone meets what was asked for; ask "
                "for more, such as a decay rate",
                ZeroGainsWarning,
                stacklevel=2,
            )
        return design

    return warned


def _are_zero(model: object, gains: Floats) -> bool:
    """Return whether the largest B_i K_j is next to nothing beside A_i, in balanced states."""
    A, B = (np.asarray(getattr(model, name), dtype=np.float64) for name in "AB")
    A, B = (matrices.reshape(-1, *matrices.shape[-2:]) for matrices in (A, B))
    step = getattr(model, "sample_time", None)
    s = state_units(A, None, step=step)
    plant = np.abs(motion(A, step)).max(axis=0)
    steered = np.abs(B).max(axis=0) @ np.abs(gains).max(axis=0)
    plant_size, steered_size = (float((x * s / s[:, None]).max()) for x in (plant, steered))
    return steered_size <= NUMERICALLY_ZERO * plant_size
