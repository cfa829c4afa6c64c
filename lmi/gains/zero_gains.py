"""A warning where a design's gains do nothing, because the plant meets the request by itself."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextvars import ContextVar
from functools import wraps
from typing import ParamSpec

import numpy as np

from takagi.lmi.answer import Design
from takagi.lmi.cone.balance import motion, state_units
from takagi.models.arrays import Floats

P = ParamSpec("P")

# Gains are zero where they move the states by less than this share of what the plant does itself.
NUMERICALLY_ZERO = 1e-4

_inside: ContextVar[bool] = ContextVar("inside of a design", default=False)


class ZeroGainsWarning(UserWarning):
    """The gains are numerically zero: the plant alone meets what was asked for."""


def warns_of_zero_gains(
    design_of: Callable[P, Design],
) -> Callable[P, Design]:
    """Return the design function with the warning; one that another calls does not warn."""

    @wraps(design_of)
    def warned(*args: P.args, **kwargs: P.kwargs) -> Design:
        if _inside.get():
            return design_of(*args, **kwargs)
        token = _inside.set(True)
        try:
            design = design_of(*args, **kwargs)
        finally:
            _inside.reset(token)
        if design.gains is not None and _are_zero(
            args[0] if args else kwargs["model"], design.gains
        ):
            warnings.warn(
                "the gains are numerically zero: the plant alone meets what was asked for; ask "
                "for more, such as a decay rate",
                ZeroGainsWarning,
                stacklevel=2,
            )
        return design

    return warned


def _are_zero(model: object, gains: Floats) -> bool:
    """Return whether B_i K_j is next to nothing beside A_i, in balanced states."""
    A, B = (np.asarray(getattr(model, name), dtype=np.float64) for name in "AB")
    step = getattr(model, "sample_time", None)
    s = state_units(A, None, step=step)
    plant, steered = (x * s / s[:, None] for x in (motion(A, step), B[:, None] @ gains[None]))
    return float(np.abs(steered).max()) <= NUMERICALLY_ZERO * float(np.abs(plant).max())
